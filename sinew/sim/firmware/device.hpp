#pragma once
#include "sinew/base/time.hpp"
#include "sinew/wire/frame.hpp"
#include "sinew/wire/protocol.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace sinew::sim {

/// What a device puts on the wire, and how long after the end of the request its first bit goes out.
struct Answer {
    wire::Frame frame;
    Duration delay{};
};

/// What a device is doing, for people to look at.
struct Look {
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    std::string_view mode; ///< "position", "passive", … in the family's own words
};

/// The firmware of one simulated device: messages in, answers out. It knows no wire and no bus, keeps its settings, and
/// carries its own plant. Single-threaded; `advance` and `hear` allocate nothing.
class Device
{
public:
    virtual ~Device() = default;

    /// Moves the device on to `now`: control and plant in fixed steps. Time never goes back.
    virtual void advance(TimePoint now) = 0;
    /// A request frame that ended on the wire at `at`, whoever it was for. The caller has advanced the device to `at`.
    virtual std::optional<Answer> hear(const wire::Frame& request, TimePoint at) = 0;

    virtual const wire::Protocol& protocol() const = 0;
    virtual int id() const = 0;
    virtual std::uint32_t bit_rate() const = 0; ///< it hears and answers at this rate only
    virtual Look look() const = 0;
    /// Power off and on: what is not stored is lost.
    virtual void power_cycle() = 0;
};

} // namespace sinew::sim
