#pragma once
#include <chrono>

namespace sinew {

using Duration = std::chrono::nanoseconds;

/// The clock of a robot: real (monotonic) or virtual. Only a `link::Clock` makes these time points; points of two
/// different clocks must not be compared.
struct RobotClock {
    using duration = Duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::time_point<RobotClock, duration>;
    static constexpr bool is_steady = true;
};

using TimePoint = RobotClock::time_point;

/// The time that `bits` take on a wire of `bit_rate` bits per second, rounded up to a nanosecond.
constexpr Duration bit_time(std::int64_t bits, std::int64_t bit_rate)
{
    return Duration{(bits * 1'000'000'000 + bit_rate - 1) / bit_rate};
}

constexpr double seconds(Duration d)
{
    return std::chrono::duration<double>(d).count();
}

} // namespace sinew
