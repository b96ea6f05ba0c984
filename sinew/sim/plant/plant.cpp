#include "sinew/sim/plant/plant.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

Plant::Plant(const Rating& rating, double position_rad) : rating_(rating), position_rad_(position_rad) {}

void Plant::release()
{
    drive_ = Drive::released;
}

void Plant::brake()
{
    drive_ = Drive::braked;
}

void Plant::follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2)
{
    drive_ = Drive::following;
    target_ = target_rad;
    velocity_limit_ = std::clamp(velocity_rad_s, 0.0, rating_.velocity_max_rad_s);
    acceleration_limit_ = std::clamp(acceleration_rad_s2, 0.0, rating_.acceleration_max_rad_s2);
}

void Plant::turn(double velocity_rad_s, double acceleration_rad_s2)
{
    drive_ = Drive::turning;
    target_ = std::clamp(velocity_rad_s, -rating_.velocity_max_rad_s, rating_.velocity_max_rad_s);
    acceleration_limit_ = std::clamp(acceleration_rad_s2, 0.0, rating_.acceleration_max_rad_s2);
}

void Plant::push(double current_a)
{
    drive_ = Drive::pushed;
    target_ = std::clamp(current_a, -rating_.current_max_a, rating_.current_max_a);
}

double Plant::friction() const
{
    return assumed_friction_share * rating_.acceleration_max_rad_s2;
}

// The greatest speed from which the shaft, slowing down by the acceleration limit in every step, ends exactly on the
// target. From v it goes on for k more steps: (k + 1) v − per_step k (k + 1) / 2 is the distance in units of a step.
double Plant::wanted_velocity() const
{
    const double distance = target_ - position_rad_;
    const double per_step = acceleration_limit_ * plant_step_s;
    if (distance == 0.0 || per_step == 0.0)
        return 0.0;
    const double rest = std::abs(distance) / plant_step_s;
    const double k = std::floor(std::sqrt(0.25 + 2.0 * rest / per_step) - 0.5);
    const double stoppable = rest / (k + 1.0) + per_step * k / 2.0;
    return std::copysign(std::min(velocity_limit_, stoppable), distance);
}

void Plant::accelerate_towards(double velocity_rad_s, double acceleration_rad_s2)
{
    const double most = acceleration_rad_s2 * plant_step_s;
    const double before = velocity_rad_s_;
    velocity_rad_s_ = std::clamp(velocity_rad_s, before - most, before + most);
    acceleration_rad_s2_ = (velocity_rad_s_ - before) / plant_step_s;
}

void Plant::step()
{
    const double most = rating_.acceleration_max_rad_s2;
    const bool driven = drive_ == Drive::following || drive_ == Drive::turning;
    if (drive_ == Drive::released) {
        accelerate_towards(0.0, friction());
    } else if (drive_ == Drive::braked) {
        accelerate_towards(0.0, most);
    } else if (drive_ == Drive::pushed) {
        const double torque = rating_.current_max_a > 0.0 ? target_ / rating_.current_max_a * most : 0.0;
        const double against = std::copysign(friction(), velocity_rad_s_ != 0.0 ? velocity_rad_s_ : torque);
        // Friction brings the shaft to rest, it never turns it.
        const bool holds = std::abs(torque) <= friction();
        const double end = holds ? 0.0 : std::copysign(rating_.velocity_max_rad_s, torque);
        accelerate_towards(end, std::abs(torque - against));
    } else {
        accelerate_towards(drive_ == Drive::following ? wanted_velocity() : target_, acceleration_limit_);
    }

    const double rest = target_ - position_rad_ - velocity_rad_s_ * plant_step_s;
    position_rad_ += velocity_rad_s_ * plant_step_s;
    // What is left of the distance after the last step is rounding.
    if (drive_ == Drive::following && std::abs(rest) < 1e-12)
        position_rad_ = target_;

    if (driven) {
        const double turning = velocity_rad_s_ == 0.0 ? 0.0 : std::copysign(friction(), velocity_rad_s_);
        current_a_ = most > 0.0 ? rating_.current_max_a * (acceleration_rad_s2_ + turning) / most : 0.0;
    } else {
        current_a_ = drive_ == Drive::pushed ? target_ : 0.0;
    }
}

double cruise_velocity(double distance_rad, double time_s, double acceleration_rad_s2)
{
    const double distance = std::abs(distance_rad);
    // time = distance / v + v / a
    const double root =
        acceleration_rad_s2 * time_s * acceleration_rad_s2 * time_s - 4.0 * acceleration_rad_s2 * distance;
    if (root < 0.0)
        return std::sqrt(acceleration_rad_s2 * distance);
    return (acceleration_rad_s2 * time_s - std::sqrt(root)) / 2.0;
}

} // namespace sinew::sim
