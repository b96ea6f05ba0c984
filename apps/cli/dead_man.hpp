#pragma once
#include "sinew/base/time.hpp"

#include <string_view>

namespace sinew::cli {

/// What keys of `jog` mean: motion only while they repeat. Pure; the caller has keys and time.
class DeadMan
{
public:
    enum class Wish { none, stop, quit, faster, slower };

    /// A terminal repeats a key first after a quarter to a whole second and then 20 to 40 times a second: one press is
    /// a nudge, and only a repeated one goes on.
    static constexpr Duration nudge = std::chrono::milliseconds(120);
    static constexpr Duration hold = std::chrono::milliseconds(200);
    static constexpr Duration repeats_within = std::chrono::milliseconds(1000);

    /// Takes the keys that were pressed; what is asked for besides motion.
    Wish press(std::string_view keys, TimePoint now);
    /// +1 and -1: to turn on; 0: not to.
    int direction(TimePoint now) const { return now < until_ ? direction_ : 0; }

private:
    void turn(int direction, TimePoint now);

    int direction_ = 0;
    TimePoint pressed_{};
    TimePoint until_{};
};

} // namespace sinew::cli
