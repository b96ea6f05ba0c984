#pragma once
#include "sinew/base/time.hpp"
#include "sinew/wire/frame.hpp"
#include "sinew/wire/protocol.hpp"

#include <cstdint>
#include <optional>
#include <span>

namespace sinew::sim {

/// What a device puts on the wire, and how long after the end of the request its first bit goes out.
struct Answer {
    wire::Frame frame;
    Duration delay{};
};

/// Whatever is connected to a simulated wire at the far end: a device as its transceiver sees it. The wire owns none of
/// them and calls them from the thread that runs it.
class Station
{
public:
    virtual ~Station() = default;

    /// Moves the device on to `now`: control and plant in fixed steps. Time never goes back.
    virtual void advance(TimePoint now) = 0;
    /// A request frame that ended on the wire at `at`, whoever it was for. The caller has advanced the device to `at`.
    virtual std::optional<Answer> hear(const wire::Frame& request, TimePoint at) = 0;

    virtual const wire::Protocol& protocol() const = 0;
    /// It hears and answers at this rate only, as it was when it was advanced last. What it answers to a message goes
    /// out at the rate from before that message.
    virtual std::uint32_t bit_rate() const = 0;
};

/// The host end of a serial wire: hears what the devices say.
class SerialHost
{
public:
    virtual ~SerialHost() = default;
    /// The rate at which it listens now; bytes at any other rate are not passed to it.
    virtual std::uint32_t bit_rate() const = 0;
    /// Bytes whose last one ended at `at`.
    virtual void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) = 0;
};

/// The host end of a CAN wire.
class CanHost
{
public:
    virtual ~CanHost() = default;
    virtual std::uint32_t bit_rate() const = 0; ///< frames at any other rate are not passed to it
    virtual void on_frame(const wire::Frame& frame, TimePoint at) = 0;
};

} // namespace sinew::sim
