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

    /// A request frame that ended on the wire at `at`: one that `wire::Protocol::addressee` says is for this station or
    /// for nobody in particular.
    virtual std::optional<Answer> hear(const wire::Frame& request, TimePoint at) = 0;
    /// What it answered has gone out whole.
    virtual void answered(TimePoint at) = 0;

    virtual const wire::Protocol& protocol() const = 0;
    virtual int id() const = 0;
    /// It also wants the requests to other ids.
    virtual bool hears_all() const { return false; }
    /// It hears and answers at this rate only; 0: it has no power, or hangs on no wire. What it answers to a message
    /// goes out at the rate from before that message.
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
