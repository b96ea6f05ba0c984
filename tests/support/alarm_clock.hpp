#pragma once
#include "sinew/link/clock.hpp"

#include <algorithm>
#include <functional>
#include <utility>

namespace sinew::test {

/// Time in which something happens while the one who drives waits, and wakes him as the descriptor of a stop does.
class AlarmClock final : public link::Clock
{
public:
    explicit AlarmClock(link::Clock& clock) : clock_(clock) {}
    void set(TimePoint at, std::function<void()> what)
    {
        at_ = at;
        what_ = std::move(what);
    }

    /// Now, if it has not happened yet.
    void make_up_for_it()
    {
        if (std::exchange(at_, TimePoint::max()) != TimePoint::max())
            what_();
    }

    TimePoint now() const override { return clock_.now(); }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        clock_.wait(handles, std::min(deadline, at_));
        if (now() >= at_)
            make_up_for_it();
    }

private:
    link::Clock& clock_;
    TimePoint at_ = TimePoint::max();
    std::function<void()> what_;
};

} // namespace sinew::test
