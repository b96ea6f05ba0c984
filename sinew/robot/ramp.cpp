#include "sinew/robot/ramp.hpp"

#include <cmath>

namespace sinew::robot {

MotionLimits slowed(const MotionLimits& limits, double speed)
{
    return {.velocity_rad_s = limits.velocity_rad_s * speed,
            .acceleration_rad_s2 = limits.acceleration_rad_s2 * speed * speed,
            .jerk_rad_s3 = limits.jerk_rad_s3 * speed * speed * speed};
}

Ramp::Ramp(double from_rad_s, double to_rad_s, const MotionLimits& limits) : from_(from_rad_s), to_(to_rad_s)
{
    const double change = std::abs(to_ - from_);
    const double sign = to_ < from_ ? -1.0 : 1.0;
    const double full_s = limits.acceleration_rad_s2 / limits.jerk_rad_s3; // 0 without a limit of jerk
    // Of a small change the greatest acceleration is not reached.
    if (change < limits.acceleration_rad_s2 * full_s) {
        jerk_s_ = std::sqrt(change / limits.jerk_rad_s3);
        acceleration_ = sign * limits.jerk_rad_s3 * jerk_s_;
    } else {
        jerk_s_ = full_s;
        hold_s_ = change / limits.acceleration_rad_s2 - full_s;
        acceleration_ = sign * limits.acceleration_rad_s2;
    }
    jerk_ = jerk_s_ > 0.0 ? acceleration_ / jerk_s_ : 0.0;
}

Setpoint Ramp::at(double t_s) const
{
    if (t_s <= jerk_s_)
        return {from_ * t_s + jerk_ * t_s * t_s * t_s / 6.0, from_ + jerk_ * t_s * t_s / 2.0, jerk_ * t_s};
    // The last part is the first one backwards, so that it ends exactly.
    const double left_s = duration_s() - t_s;
    if (left_s < jerk_s_)
        return {distance_rad() - to_ * left_s + jerk_ * left_s * left_s * left_s / 6.0,
                to_ - jerk_ * left_s * left_s / 2.0, jerk_ * left_s};
    const double held_s = t_s - jerk_s_;
    const double entry = from_ + jerk_ * jerk_s_ * jerk_s_ / 2.0;
    const double before = from_ * jerk_s_ + jerk_ * jerk_s_ * jerk_s_ * jerk_s_ / 6.0;
    return {before + entry * held_s + acceleration_ * held_s * held_s / 2.0, entry + acceleration_ * held_s,
            acceleration_};
}

} // namespace sinew::robot
