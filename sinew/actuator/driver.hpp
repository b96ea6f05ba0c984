#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/base/error.hpp"
#include "sinew/wire/request.hpp"

#include <expected>

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

    /// The requests that carry out `command`. `unsupported` or `out_of_range` with the reason, and nothing planned,
    /// when the device cannot do it. Mode hold needs a state with a position where the protocol has no command for it.
    virtual std::expected<wire::Requests, Error> plan(const Command& command, const State& state) = 0;

    /// The requests whose replies make up a state.
    virtual std::expected<wire::Requests, Error> plan_read(Depth depth) = 0;

    /// Puts what a reply tells into `state`. Replies that tell nothing of the state are fine and change nothing.
    virtual std::expected<void, Error> absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                              State& state) = 0;
};

} // namespace sinew::actuator
