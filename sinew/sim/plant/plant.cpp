#include "sinew/sim/plant/plant.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

/// One step is v' = (v + dt/J · (push + load − friction)) / (1 + dt/J · damping): what grows with speed is taken at the
/// end of the step, so that no gain is too stiff for it. Which way power goes through the gearbox decides what it
/// costs.
struct Plant::Motor {
    struct Way {
        double nm_per_a = 0.0;
        double push = 0.0;   ///< dt/J · torque at rest
        double shrink = 1.0; ///< 1 / (1 + dt/J · damping)
    };

    Motor(const PlantParameters& p, Drive drive, double driven, double supply)
        : supply_v(supply), per_ohm(1.0 / p.winding_ohm), v_s_per_rad(p.voltage_constant_v_s_per_rad()),
          step_per_j(plant_step_s / p.inertia_kg_m2()), is_current(drive == Drive::current),
          is_open(drive == Drive::open), wanted_a(driven), terminal_v(drive == Drive::duty ? driven * supply : 0.0)
    {
        driving.nm_per_a = p.torque_per_ampere_nm();
        driven_back.nm_per_a = v_s_per_rad / p.gear_efficiency;
        for (Way* way : {&driving, &driven_back}) {
            double damping = p.viscous_friction_nm_s_per_rad;
            if (drive == Drive::duty) {
                damping += way->nm_per_a * v_s_per_rad * per_ohm;
                way->push = step_per_j * way->nm_per_a * terminal_v * per_ohm;
            }
            way->shrink = 1.0 / (1.0 + step_per_j * damping);
        }
    }

    double current(double velocity) const
    {
        if (is_open)
            return 0.0;
        const double back_emf_v = v_s_per_rad * velocity;
        if (!is_current)
            return (terminal_v - back_emf_v) * per_ohm;
        const double least = (-supply_v - back_emf_v) * per_ohm;
        const double most = (supply_v - back_emf_v) * per_ohm;
        return std::clamp(wanted_a, least, most);
    }
    double voltage(double current, double velocity) const
    {
        return is_current ? current / per_ohm + v_s_per_rad * velocity : terminal_v;
    }
    const Way& way(double current, double velocity) const { return current * velocity >= 0.0 ? driving : driven_back; }
    /// What the current alone adds to the speed in one step.
    double kick(const Way& way, double current) const
    {
        return is_current ? step_per_j * way.nm_per_a * current : way.push;
    }

    double supply_v;
    double per_ohm;
    double v_s_per_rad;
    double step_per_j;
    bool is_current;
    bool is_open;
    double wanted_a;
    double terminal_v;
    Way driving;
    Way driven_back;
};

Plant::Plant(const PlantParameters& parameters, double position_rad)
    : parameters_(parameters),
      position_rad_(std::clamp(position_rad, parameters.stop_min_rad, parameters.stop_max_rad)),
      winding_c_(parameters.ambient_c), case_c_(parameters.ambient_c)
{
}

void Plant::open()
{
    drive_ = Drive::open;
    driven_ = 0.0;
}

void Plant::short_circuit()
{
    drive_duty(0.0);
}

void Plant::drive_duty(double duty)
{
    drive_ = Drive::duty;
    driven_ = std::clamp(duty, -1.0, 1.0);
}

void Plant::drive_current(double current_a)
{
    drive_ = Drive::current;
    driven_ = current_a;
}

double Plant::load_torque() const
{
    const double gravity = parameters_.gravity_torque_nm == 0.0
                               ? 0.0
                               : parameters_.gravity_torque_nm * std::sin(position_rad_ - parameters_.gravity_zero_rad);
    return parameters_.external_torque_nm + pushed_nm_ - gravity;
}

void Plant::run(double supply_v)
{
    const Motor motor(parameters_, drive_, driven_, supply_v);
    const double before = velocity_rad_s_;
    double load = load_torque();

    // Nothing turns and nothing is strong enough to start it: the ten steps are all the same.
    const double at_rest_a = motor.current(0.0);
    const double start_nm = motor.driving.nm_per_a * at_rest_a + load;
    const bool sticks = velocity_rad_s_ == 0.0 && std::abs(start_nm) <= parameters_.static_friction_nm;
    if (sticks || jammed_) {
        velocity_rad_s_ = 0.0;
        acceleration_rad_s2_ = -before / tick_s;
        current_a_ = at_rest_a;
        supply_current_a_ = supply_v > 0.0 ? at_rest_a * motor.voltage(at_rest_a, 0.0) / supply_v : 0.0;
        warm(at_rest_a * at_rest_a * parameters_.winding_ohm);
        return;
    }

    const double kinetic = parameters_.coulomb_friction_nm * motor.step_per_j;
    const double gravity = parameters_.gravity_torque_nm;
    const double constant = parameters_.external_torque_nm + pushed_nm_;
    double sine = 0.0;
    double cosine = 1.0;
    if (gravity != 0.0) {
        sine = std::sin(position_rad_ - parameters_.gravity_zero_rad);
        cosine = std::cos(position_rad_ - parameters_.gravity_zero_rad);
    }
    double v = velocity_rad_s_;
    double x = position_rad_;
    double amperes = 0.0, squares = 0.0, watts = 0.0;
    for (int i = 0; i < steps_per_tick; ++i) {
        const double a = motor.current(v);
        const Motor::Way& way = motor.way(a, v);
        amperes += a;
        squares += a * a;
        watts += a * motor.voltage(a, v);
        load = constant - gravity * sine;
        const double kicked = motor.kick(way, a) + motor.step_per_j * load;
        double next = 0.0;
        if (v == 0.0) {
            const double torque = way.nm_per_a * a + load;
            if (std::abs(torque) > parameters_.static_friction_nm)
                next = (kicked - std::copysign(kinetic, torque)) * way.shrink;
        } else {
            next = (v + kicked - std::copysign(kinetic, v)) * way.shrink;
            if (next * v < 0.0) // through zero: it rests there for a step
                next = 0.0;
        }
        v = next;
        const double way_rad = plant_step_s * v;
        x += way_rad;
        if (x >= parameters_.stop_max_rad || x <= parameters_.stop_min_rad) {
            x = std::clamp(x, parameters_.stop_min_rad, parameters_.stop_max_rad);
            const bool outward = (v > 0.0) == (x == parameters_.stop_max_rad);
            if (outward)
                v = 0.0;
        }
        // The angle turns on by a small step: exact to its third power, and afresh every tick.
        const double turned = sine + way_rad * (cosine - 0.5 * way_rad * sine);
        cosine -= way_rad * (sine + 0.5 * way_rad * cosine);
        sine = turned;
    }
    velocity_rad_s_ = v;
    position_rad_ = x;
    acceleration_rad_s2_ = (v - before) / tick_s;
    current_a_ = amperes / steps_per_tick;
    supply_current_a_ = supply_v > 0.0 ? watts / (steps_per_tick * supply_v) : 0.0;
    warm(squares / steps_per_tick * parameters_.winding_ohm);
}

void Plant::warm(double copper_w)
{
    const double to_case_w = (winding_c_ - case_c_) / parameters_.winding_to_case_k_per_w;
    const double to_air_w = (case_c_ - parameters_.ambient_c) / parameters_.case_to_ambient_k_per_w;
    winding_c_ += (copper_w - to_case_w) * tick_s / parameters_.winding_heat_capacity_j_per_k;
    case_c_ += (to_case_w - to_air_w) * tick_s / parameters_.case_heat_capacity_j_per_k;
}

} // namespace sinew::sim
