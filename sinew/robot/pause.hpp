#pragma once
#include "sinew/base/time.hpp"

#include <algorithm>

namespace sinew::robot {

/// The last time that a loop was kept from turning: by the machine, by a debugger, by a slow turn of its own. It asked
/// nobody then, so a device that seems silent after it need not be at fault.
class Pause
{
public:
    /// The loop turns.
    void turn(TimePoint now)
    {
        if (awaited_ != TimePoint{} && now - awaited_ > unnoticed) {
            time_ = now - awaited_;
            until_ = now;
        }
        awaited_ = now;
    }
    /// Until then it means to rest.
    void rest_until(TimePoint wake) { awaited_ = std::max(awaited_, wake); }
    /// From now on it is awaited, whoever turns it.
    void begin(TimePoint now) { awaited_ = now; }

    /// The pause that makes up most of a silence, or zero.
    Duration within(TimePoint answered, TimePoint now) const
    {
        return until_ > answered && 2 * time_ > now - answered ? time_ : Duration{};
    }

private:
    static constexpr Duration unnoticed = std::chrono::milliseconds{100};

    TimePoint awaited_{};
    TimePoint until_{};
    Duration time_{};
};

} // namespace sinew::robot
