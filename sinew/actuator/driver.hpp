#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/base/error.hpp"
#include "sinew/wire/request.hpp"

#include <expected>
#include <string_view>

namespace sinew::actuator {

/// How much of a state is wanted.
enum class Depth : std::uint8_t {
    motion, ///< position and whatever comes with it, in as few exchanges as the protocol allows
    full,   ///< everything the device can measure, and its faults
};

/// The only place that knows what messages mean in SI. Pure: no I/O, no time of its own, no heap in steady use; one per
/// actuator, used from one thread. It never sends anything: it plans requests and reads replies.
class Driver
{
public:
    virtual ~Driver() = default;

    virtual const Capabilities& capabilities() const = 0;

    // ---- motion ----

    /// The requests that carry out `command`, in order. An error with the reason, and nothing planned, when the device
    /// cannot do it. `state`: what was measured last; mode hold, and a move with a duration, need its position where
    /// the protocol has no message for them.
    virtual std::expected<wire::Requests, Error> plan(const Command& command, const State& state) = 0;

    /// Drives with nothing and stays on, so that its loops begin anew with the next command. `unsupported` where a
    /// device has no way to do so short of being switched off.
    virtual std::expected<wire::Requests, Error> plan_idle()
    {
        return fail(Errc::unsupported, "it cannot drive with nothing without being switched off");
    }

    /// The requests whose replies make up a state, in the shortest messages that are at least as fine as
    /// `resolution_rad`; 0: the finest.
    virtual std::expected<wire::Requests, Error> plan_read(Depth depth, double resolution_rad = 0.0) = 0;

    /// One turn of a control loop: what carries out `command`, and as few further requests as bring a position that is
    /// fresh. None where the answer to the command tells it.
    virtual std::expected<wire::Requests, Error> plan_cycle(const Command& command, const State& state) = 0;

    /// Puts what a reply tells into `state`. Replies that tell nothing of the state are fine and change nothing. `at`
    /// is when the values were measured, as near as the caller knows: the arrival of the reply, less its time on a slow
    /// wire. What a reply does not tell keeps its value and its time.
    virtual std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                              State& state) = 0;

    // ---- what a device forgets at power-off ----

    /// The requests that apply the run-time settings of the robot file; none: it names none. Also begins to look out
    /// for a reset anew.
    virtual std::expected<wire::Requests, Error> plan_settings() = 0;

    /// Requests whose replies tell whether the device has started afresh since `plan_settings`; none: this one cannot
    /// tell. Ask now and then, and whenever the device was silent.
    virtual std::expected<wire::Requests, Error> plan_reset_check() = 0;

    /// What showed that the device has started afresh, among all that was absorbed since `plan_settings`. Empty:
    /// nothing did, which proves nothing where a protocol is silent about it.
    virtual std::string_view noticed_reset() const = 0;

    /// Whether it may count from elsewhere since this was asked last: what was planned or noticed has taken whole turns
    /// off, or may have. Asking forgets it.
    virtual bool take_lost_count() { return false; }
};

} // namespace sinew::actuator
