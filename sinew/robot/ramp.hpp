#pragma once
#include <limits>

namespace sinew::robot {

/// Where a joint is to be at one moment.
struct Setpoint {
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    double acceleration_rad_s2 = 0.0;
};

/// What a motion of one joint may not exceed, each above 0. A jerk without end makes trapezoids of the velocity.
struct MotionLimits {
    double velocity_rad_s = 0.0;
    double acceleration_rad_s2 = 0.0;
    double jerk_rad_s3 = std::numeric_limits<double>::infinity();
};

/// The limits of the same motion at a share of its speed, above 0 up to 1: it takes as many times as long.
MotionLimits slowed(const MotionLimits& limits, double speed);

/// The shortest change from one velocity to another that begins and ends without acceleration: jerk up, constant
/// acceleration (none where the change is small), jerk down. A plain value; times in seconds.
class Ramp
{
public:
    Ramp() = default;
    Ramp(double from_rad_s, double to_rad_s, const MotionLimits& limits);

    double duration_s() const { return 2.0 * jerk_s_ + hold_s_; }
    double distance_rad() const { return 0.5 * (from_ + to_) * duration_s(); }
    /// The position counts from where the ramp begins. `t_s` from 0 to the duration.
    Setpoint at(double t_s) const;

private:
    double from_ = 0.0, to_ = 0.0;
    double acceleration_ = 0.0, jerk_ = 0.0; ///< both with the sign of the change
    double jerk_s_ = 0.0, hold_s_ = 0.0;
};

} // namespace sinew::robot
