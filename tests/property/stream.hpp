#pragma once
#include "sinew/wire/protocol.hpp"
#include "tests/property/sides.hpp"

#include <vector>

/// Byte streams as a port sees them, and the frames that a framing finds in them.
namespace sinew::property {

/// Which end of the wire listens.
struct Listener {
    const test::Family* family = nullptr;
    wire::Direction hears{};
    std::size_t awaited = 0; ///< SAM replies

    wire::Scan find(std::span<const std::uint8_t> bytes, bool silent) const;
    const char* name() const;
};

/// Both ends of Nuri, and the device's end of SAM. SAM replies carry no framing.
std::vector<Listener> listeners();

/// A frame and where in the stream it began.
struct Found {
    std::size_t at = 0;
    std::vector<std::uint8_t> bytes;
    friend bool operator==(const Found&, const Found&) = default;
};

/// What a listener makes of bytes that come in pieces.
class Receiver
{
public:
    explicit Receiver(const Listener& listener) : listener_(listener) {}

    void hear(std::span<const std::uint8_t> bytes);
    void fall_silent();
    const std::vector<Found>& found() const { return found_; }

private:
    void scan(bool silent);

    const Listener& listener_;
    std::vector<std::uint8_t> waiting_;
    std::size_t dropped_ = 0;
    std::vector<Found> found_;
};

/// A frame of any message that the listener hears.
std::vector<std::uint8_t> any_frame(const Listener& listener, test::Random& random);

/// Bytes of any kind; header bytes and the beginnings of frames come up often.
std::vector<std::uint8_t> garbage(const Listener& listener, test::Random& random);

} // namespace sinew::property
