#pragma once
#include "sinew/robot/joint.hpp"
#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::robot::test {

/// How far a shaft may go beyond a limit, from what its plant is made of: the only place that says so.
///
/// It crosses the limit at some velocity and may be driven on, with all the torque there is at its supply, until the
/// robot has heard of it and told it to hold: two cycles and as long as the device has not been heard. Then its
/// velocity fades with the time constant of a shorted winding, which a loop that damps does not exceed. A shaft that
/// was let go has its friction alone.
class Beyond
{
public:
    explicit Beyond(const Joint& joint)
    {
        const auto rating = sim::rating_of(joint.device());
        const auto plant = sim::plant_of(joint.device());
        const double ratio = joint.file().ratio;
        top_rad_s_ = rating.velocity_max_rad_s / ratio;
        braking_rad_s2_ = rating.acceleration_max_rad_s2 / ratio;
        coasting_rad_s2_ = plant.coulomb_friction_nm / plant.inertia_kg_m2() / ratio;
    }
    /// `velocity_rad_s`: where it crossed the limit; `unnoticed`: until it was told.
    double most_rad(double velocity_rad_s, Duration unnoticed, bool is_let_go) const
    {
        const double t = seconds(unnoticed), v = std::abs(velocity_rad_s);
        const double then = std::max(v, std::min(top_rad_s_, v + braking_rad_s2_ * t));
        const double driven = std::min(v * t + braking_rad_s2_ * t * t / 2.0, then * t);
        const double stopping =
            is_let_go ? then * then / (2.0 * coasting_rad_s2_) : then * top_rad_s_ / braking_rad_s2_;
        return driven + stopping + resolution_rad;
    }

private:
    static constexpr double resolution_rad = units::rad(1.0); ///< of the coarsest reading (SAM, quick)
    double top_rad_s_, braking_rad_s2_, coasting_rad_s2_;
};

} // namespace sinew::robot::test
