#pragma once
#include "sinew/base/error.hpp"
#include "sinew/base/time.hpp"
#include "sinew/robot/ramp.hpp"

#include <expected>

namespace sinew::robot {

/// One joint on its way from where it is, moving or not, to a target where it rests: a ramp to a velocity, that
/// velocity for a while, a ramp to rest. Seven segments with a limit of jerk (an S-curve), three without. A plain value
/// without heap; every moment of it is worked out in closed form, in any order, from any thread.
///
/// Velocity, acceleration and jerk never exceed their limits. A start that is faster than the limit comes down to it
/// first; one that is too fast to stop before the target goes past it and comes back. A start has no acceleration.
class Trajectory
{
public:
    /// At rest at 0.
    Trajectory() = default;

    /// The soonest arrival. `bad_argument` for numbers that are none and limits that are not above 0.
    static std::expected<Trajectory, Error> plan(double from_rad, double from_velocity_rad_s, double target_rad,
                                                 const MotionLimits& limits);
    /// Comes to rest as soon as it can, wherever that is.
    static std::expected<Trajectory, Error> stop(double from_rad, double from_velocity_rad_s,
                                                 const MotionLimits& limits);

    /// The same way in a longer time. From rest it is the same motion, slower throughout; a moving start keeps its
    /// limits and goes on at another velocity. `out_of_range` where it cannot take exactly so long: see `reachable`.
    std::expected<Trajectory, Error> lasting(Duration duration) const;
    /// The shortest duration from `at_least` on that it can have. A moving start leaves some out: it cannot wait
    /// without having come to rest.
    Duration reachable(Duration at_least) const;

    /// Rounded up to a nanosecond.
    Duration duration() const;
    double target_rad() const { return target_; }

    /// Before the beginning the start, from the end on the target at rest, exactly.
    Setpoint at(Duration since_start) const;

private:
    // Everything below counts in the direction of the start's velocity, or of the target from rest: a peak is the
    // velocity between the two ramps.

    /// Peaks between which none leaves a way to cruise that is not negative; equal: there is no such gap.
    struct Gap {
        double low = 0.0, high = 0.0;
    };

    double ramps_distance(double peak) const;
    double time_s(double peak) const;
    bool fits(double peak) const;
    double widest_peak() const;
    double soonest_peak() const;
    Gap gap() const;
    double peak_lasting(double duration_s) const;
    void set_peak(double peak, double duration_s, const MotionLimits& limits);

    MotionLimits limits_;
    double from_ = 0.0, target_ = 0.0, sign_ = 1.0;
    double speed_ = 0.0;     ///< of the start, not below 0
    double way_ = 0.0;       ///< to the target
    double stop_way_ = 0.0;  ///< of an immediate stop
    double soonest_s_ = 0.0; ///< the shortest duration
    double peak_ = 0.0, cruise_s_ = 0.0, duration_s_ = 0.0;
    Ramp first_, last_;
};

} // namespace sinew::robot
