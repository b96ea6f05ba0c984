#pragma once
#include "sinew/base/time.hpp"

#include <cstddef>
#include <span>

namespace sinew::link {

/// What a wait looks at: a descriptor of the operating system, or -1 for a link that has none (virtual links wake
/// their clock themselves).
struct Handle {
    int fd = -1;
    bool wants_write = false; ///< also wake when the descriptor takes bytes again
};

/// Where time comes from, and the only place where a thread of sinew waits. One per robot, shared by its links; it must
/// outlive them. Not for use from two threads at once, except `now()`.
class Clock
{
public:
    virtual ~Clock() = default;
    virtual TimePoint now() const = 0;
    /// Returns when a handle is ready, when a virtual link received something, or at the deadline. May return early.
    /// Handles with fd -1 are passed over; a deadline that is gone only looks.
    virtual void wait(std::span<const Handle> handles, TimePoint deadline) = 0;
    /// The same for a caller who has the time already: `now`, as asked a moment ago.
    virtual void wait_since([[maybe_unused]] TimePoint now, std::span<const Handle> handles, TimePoint deadline)
    {
        wait(handles, deadline);
    }
};

/// CLOCK_MONOTONIC and ppoll. A signal ends a wait early.
class RealClock final : public Clock
{
public:
    TimePoint now() const override;
    void wait(std::span<const Handle> handles, TimePoint deadline) override { wait_since(now(), handles, deadline); }
    void wait_since(TimePoint now, std::span<const Handle> handles, TimePoint deadline) override;
};

} // namespace sinew::link
