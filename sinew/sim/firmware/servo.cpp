#include "sinew/sim/firmware/servo.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

Rating rating_of(const PlantParameters& plant, double supply_v)
{
    const double current = supply_v / plant.winding_ohm;
    const double volts_per_nm = plant.winding_ohm / plant.torque_per_ampere_nm();
    const double no_load = (supply_v - volts_per_nm * plant.coulomb_friction_nm) /
                           (plant.voltage_constant_v_s_per_rad() + volts_per_nm * plant.viscous_friction_nm_s_per_rad);
    return {.velocity_max_rad_s = std::max(0.0, no_load),
            .acceleration_max_rad_s2 = current * plant.torque_per_ampere_nm() / plant.inertia_kg_m2(),
            .current_max_a = current};
}

void Trajectory::start(double position_rad, double velocity_rad_s)
{
    position_rad_ = position_rad;
    velocity_rad_s_ = velocity_rad_s;
    acceleration_rad_s2_ = 0.0;
}

void Trajectory::follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2)
{
    is_following_ = true;
    target_ = target_rad;
    velocity_limit_ = velocity_rad_s;
    acceleration_limit_ = acceleration_rad_s2;
}

void Trajectory::turn(double velocity_rad_s, double acceleration_rad_s2, double after_s)
{
    is_following_ = false;
    target_ = velocity_rad_s;
    acceleration_limit_ = acceleration_rad_s2;
    ramp_s_ = after_s;
}

// By what is left of the time, not by what it was at first: a trajectory that waits for its shaft starts from where
// that is, and must come there all the same.
double Trajectory::most_acceleration() const
{
    if (is_following_ || ramp_s_ < tick_s)
        return acceleration_limit_;
    return std::min(acceleration_limit_, std::abs(target_ - velocity_rad_s_) / ramp_s_);
}

// The greatest speed from which the shaft, slowing down by the acceleration limit in every step, ends exactly on the
// target. From v it goes on for k more steps: (k + 1) v − per_step k (k + 1) / 2 is the distance in units of a step.
double Trajectory::wanted_velocity() const
{
    const double distance = target_ - position_rad_;
    const double per_step = acceleration_limit_ * tick_s;
    if (distance == 0.0 || per_step == 0.0)
        return 0.0;
    const double rest = std::abs(distance) / tick_s;
    const double k = std::floor(std::sqrt(0.25 + 2.0 * rest / per_step) - 0.5);
    const double stoppable = rest / (k + 1.0) + per_step * k / 2.0;
    return std::copysign(std::min(velocity_limit_, stoppable), distance);
}

void Trajectory::step()
{
    const double most = most_acceleration() * tick_s;
    ramp_s_ = std::max(0.0, ramp_s_ - tick_s);
    const double before = velocity_rad_s_;
    velocity_rad_s_ = std::clamp(is_following_ ? wanted_velocity() : target_, before - most, before + most);
    acceleration_rad_s2_ = (velocity_rad_s_ - before) / tick_s;
    const double rest = target_ - position_rad_ - velocity_rad_s_ * tick_s;
    position_rad_ += velocity_rad_s_ * tick_s;
    // What is left of the distance after the last step is rounding.
    if (is_following_ && std::abs(rest) < 1e-12)
        position_rad_ = target_;
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

void Servo::release()
{
    drive_ = Drive::released;
}

void Servo::brake()
{
    drive_ = Drive::braked;
}

void Servo::begin()
{
    if (drive_ != Drive::following) {
        trajectory_.start(plant_->position_rad(), plant_->velocity_rad_s());
        integral_rad_s_ = 0.0;
    }
    drive_ = Drive::following;
}

void Servo::follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2)
{
    begin();
    trajectory_.follow(target_rad, std::clamp(velocity_rad_s, 0.0, rating_.velocity_max_rad_s),
                       std::clamp(acceleration_rad_s2, 0.0, rating_.acceleration_max_rad_s2));
}

void Servo::turn(double velocity_rad_s, double acceleration_rad_s2, double after_s)
{
    begin();
    trajectory_.turn(std::clamp(velocity_rad_s, -rating_.velocity_max_rad_s, rating_.velocity_max_rad_s),
                     std::clamp(acceleration_rad_s2, 0.0, rating_.acceleration_max_rad_s2), after_s);
}

void Servo::push(double current_a)
{
    drive_ = Drive::pushed;
    driven_ = std::clamp(current_a, -rating_.current_max_a, rating_.current_max_a);
}

void Servo::drive(double duty)
{
    drive_ = Drive::driven;
    driven_ = duty;
}

void Servo::control()
{
    switch (drive_) {
    case Drive::released:
        return plant_->open();
    case Drive::braked:
        return plant_->short_circuit();
    case Drive::pushed:
        return plant_->drive_current(driven_);
    case Drive::driven:
        return plant_->drive_duty(driven_);
    case Drive::following:
        return hold_to_trajectory();
    }
}

void Servo::hold_to_trajectory()
{
    trajectory_.step();
    const PlantParameters& p = plant_->parameters();
    constexpr double integral_per_s = 40.0;
    const double stiffness = gains_.stiffness * frequency_rad_s * frequency_rad_s;
    const double error = trajectory_.position_rad() - plant_->position_rad();
    const double error_v = trajectory_.velocity_rad_s() - plant_->velocity_rad_s();
    // Near enough at rest: it would creep between sticking and slipping for ever.
    constexpr double near_enough_rad = 2e-5;
    const bool stands = trajectory_.velocity_rad_s() == 0.0;
    const bool rests = stands && std::abs(error) < near_enough_rad;
    const double towards = rests ? 0.0 : stands ? error : trajectory_.velocity_rad_s();
    const double friction = (towards == 0.0 ? 0.0 : std::copysign(p.coulomb_friction_nm, towards)) +
                            p.viscous_friction_nm_s_per_rad * trajectory_.velocity_rad_s();
    const double integral = gains_.integral * integral_per_s * integral_rad_s_;
    const double acceleration = trajectory_.acceleration_rad_s2() + gains_.damping * 2.0 * frequency_rad_s * error_v +
                                stiffness * (error + integral);
    const double wanted = (p.inertia_kg_m2() * acceleration + friction) / p.torque_per_ampere_nm();
    const double most = std::clamp(limit_a_, 0.0, rating_.current_max_a);
    const double current = std::clamp(wanted, -most, most);
    plant_->drive_current(current);

    if (current == wanted) {
        if (!rests)
            integral_rad_s_ += error * tick_s;
        return;
    }
    // The lead for which the loop asks all that the motor has; more of it would only be made up for later.
    const double lead = p.torque_per_ampere_nm() * rating_.current_max_a / (p.inertia_kg_m2() * stiffness);
    if (std::abs(error) > lead)
        trajectory_.start(plant_->position_rad() + std::copysign(lead, error), plant_->velocity_rad_s());
}

} // namespace sinew::sim
