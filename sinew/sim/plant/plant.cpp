#include "sinew/sim/plant/plant.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

namespace {

constexpr double ticks_per_s = 1.0 / tick_s;
constexpr double steps_per_s = 1.0 / plant_step_s;
constexpr double per_step = 1.0 / steps_per_tick;

// Turning sine and cosine on step by step is exact to the third power of a step: over this way the error stays below
// 1e-8 at 1 000 deg/s.
constexpr double looks_again_rad = 0.03;

} // namespace

Plant::Factors::Factors(const PlantParameters& p)
    : per_ohm(1.0 / p.winding_ohm), v_s_per_rad(p.voltage_constant_v_s_per_rad()),
      rad_per_nm(plant_step_s * plant_step_s / p.inertia_kg_m2()), kinetic_rad(rad_per_nm * p.coulomb_friction_nm),
      static_rad(rad_per_nm * p.static_friction_nm), hanging_rad(rad_per_nm * p.gravity_torque_nm),
      per_hanging_rad(hanging_rad != 0.0 ? 1.0 / hanging_rad : 0.0),
      winding_k_per_w(tick_s / p.winding_heat_capacity_j_per_k), case_k_per_w(tick_s / p.case_heat_capacity_j_per_k),
      winding_to_case_w_per_k(1.0 / p.winding_to_case_k_per_w), case_to_ambient_w_per_k(1.0 / p.case_to_ambient_k_per_w)
{
    const double step_per_j = plant_step_s / p.inertia_kg_m2();
    const auto shrink_by = [&](double damping_nm_s_per_rad) { return 1.0 / (1.0 + step_per_j * damping_nm_s_per_rad); };
    shrink = shrink_by(p.viscous_friction_nm_s_per_rad);
    driving.nm_per_a = p.torque_per_ampere_nm();
    driven_back.nm_per_a = v_s_per_rad / p.gear_efficiency;
    for (Way* way : {&driving, &driven_back}) {
        way->rad_per_v = rad_per_nm * way->nm_per_a * per_ohm;
        way->shrink_duty = shrink_by(p.viscous_friction_nm_s_per_rad + way->nm_per_a * v_s_per_rad * per_ohm);
    }
}

/// Over the steps of one tick.
struct Plant::Sums {
    double amperes = 0.0;
    double squares = 0.0;
    double watts = 0.0; ///< `Drive::current` alone
};

Plant::Plant(const PlantParameters& parameters, double position_rad)
    : parameters_(parameters), factors_(parameters),
      position_rad_(std::clamp(position_rad, parameters.stop_min_rad, parameters.stop_max_rad)),
      winding_c_(parameters.ambient_c), case_c_(parameters.ambient_c)
{
    look_at_the_angle();
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

void Plant::look_at_the_angle()
{
    if (parameters_.gravity_torque_nm == 0.0 || std::abs(position_rad_ - looked_at_rad_) < looks_again_rad)
        return;
    sine_ = std::sin(position_rad_ - parameters_.gravity_zero_rad);
    cosine_ = std::cos(position_rad_ - parameters_.gravity_zero_rad);
    looked_at_rad_ = position_rad_;
}

double Plant::load_torque() const
{
    return external_nm() - parameters_.gravity_torque_nm * sine_;
}

void Plant::run(double supply_v)
{
    look_at_the_angle();
    if (jammed_ || velocity_rad_s_ == 0.0) {
        double at_rest_a = 0.0;
        if (drive_ == Drive::duty)
            at_rest_a = driven_ * supply_v * factors_.per_ohm;
        else if (drive_ == Drive::current)
            at_rest_a = std::clamp(driven_, -supply_v * factors_.per_ohm, supply_v * factors_.per_ohm);
        const double start_nm = factors_.driving.nm_per_a * at_rest_a + load_torque();
        if (jammed_ || std::abs(start_nm) <= parameters_.static_friction_nm) {
            rest(supply_v, at_rest_a);
            return;
        }
    }
    const double before = velocity_rad_s_;
    const Sums sums = turn(supply_v);
    acceleration_rad_s2_ = (velocity_rad_s_ - before) * ticks_per_s;
    current_a_ = sums.amperes * per_step;
    supply_current_a_ = 0.0;
    if (supply_v > 0.0)
        supply_current_a_ = drive_ == Drive::current ? sums.watts * per_step / supply_v
                                                     : (drive_ == Drive::duty ? driven_ * current_a_ : 0.0);
    warm(sums.squares * per_step * parameters_.winding_ohm);
}

/// Nothing turns and nothing is strong enough to start it: the ten steps are all the same.
void Plant::rest(double supply_v, double current_a)
{
    acceleration_rad_s2_ = -velocity_rad_s_ * ticks_per_s;
    velocity_rad_s_ = 0.0;
    current_a_ = current_a;
    const double copper_w = current_a * current_a * parameters_.winding_ohm;
    supply_current_a_ = 0.0;
    if (supply_v > 0.0)
        supply_current_a_ =
            drive_ == Drive::current ? copper_w / supply_v : (drive_ == Drive::duty ? driven_ * current_a : 0.0);
    warm(copper_w);
}

Plant::Sums Plant::turn(double supply_v)
{
    const bool hangs = parameters_.gravity_torque_nm != 0.0;
    switch (drive_) {
    case Drive::open:
        return hangs ? turn<Drive::open, true>(supply_v) : turn<Drive::open, false>(supply_v);
    case Drive::duty:
        return hangs ? turn<Drive::duty, true>(supply_v) : turn<Drive::duty, false>(supply_v);
    case Drive::current:
        break;
    }
    return hangs ? turn<Drive::current, true>(supply_v) : turn<Drive::current, false>(supply_v);
}

/// One step is v' = (v + dt/J · (push + load − friction)) / (1 + dt/J · damping): what grows with speed is taken at the
/// end of the step, so that no gain is too stiff for it. Speeds stand here as the way of one step, v · dt. What one
/// step waits for of the one before is kept short: speed, sine, speed; and the rare cases are branches, so that nothing
/// waits for them.
template <Plant::Drive D, bool Hangs>
Plant::Sums Plant::turn(double supply_v)
{
    const Factors& f = factors_;
    const double terminal_v = driven_ * supply_v; // of `Drive::duty`
    const double emf_v_per_rad = f.v_s_per_rad * steps_per_s;
    const double pushed_rad = f.rad_per_nm * external_nm();
    double driving_rad = pushed_rad;
    double driven_back_rad = pushed_rad;
    double driving_shrink = f.shrink;
    double driven_back_shrink = f.shrink;
    if constexpr (D == Drive::duty) {
        driving_rad += f.driving.rad_per_v * terminal_v;
        driven_back_rad += f.driven_back.rad_per_v * terminal_v;
        driving_shrink = f.driving.shrink_duty;
        driven_back_shrink = f.driven_back.shrink_duty;
    }
    double way_rad = velocity_rad_s_ * plant_step_s;
    double x = position_rad_;
    // Sine and cosine of the angle, times what gravity takes at most.
    double sine_rad = f.hanging_rad * sine_;
    double cosine_rad = f.hanging_rad * cosine_;
    Sums sums;
    for (int i = 0; i < steps_per_tick; ++i) {
        double a = 0.0;
        if constexpr (D == Drive::duty) {
            a = (terminal_v - emf_v_per_rad * way_rad) * f.per_ohm;
        } else if constexpr (D == Drive::current) {
            const double emf_v = emf_v_per_rad * way_rad;
            a = std::clamp(driven_, (-supply_v - emf_v) * f.per_ohm, (supply_v - emf_v) * f.per_ohm);
            sums.watts += a * (a * parameters_.winding_ohm + emf_v);
        }
        sums.amperes += a;
        sums.squares += a * a;

        double kick = driving_rad;
        double shrink = driving_shrink;
        double nm_per_a = f.driving.nm_per_a;
        if (D != Drive::open && a * way_rad < 0.0) [[unlikely]] {
            kick = driven_back_rad;
            shrink = driven_back_shrink;
            nm_per_a = f.driven_back.nm_per_a;
        }
        if constexpr (D == Drive::current)
            kick += f.rad_per_nm * nm_per_a * a;
        double next = (way_rad - std::copysign(f.kinetic_rad, way_rad) + kick - sine_rad) * shrink;
        if (next * way_rad <= 0.0) [[unlikely]] { // through zero: it rests there for a step; or it rests, and may start
            next = 0.0;
            if (way_rad == 0.0) {
                kick -= sine_rad;
                if (std::abs(kick) > f.static_rad)
                    next = (kick - std::copysign(f.kinetic_rad, kick)) * shrink;
            }
        }
        way_rad = next;
        x += way_rad;
        double turned_rad = way_rad;
        if (x >= parameters_.stop_max_rad || x <= parameters_.stop_min_rad) [[unlikely]] {
            const double stopped = std::clamp(x, parameters_.stop_min_rad, parameters_.stop_max_rad);
            turned_rad -= x - stopped;
            x = stopped;
            const bool outward = (way_rad > 0.0) == (x == parameters_.stop_max_rad);
            if (outward)
                way_rad = 0.0;
        }
        if constexpr (Hangs) {
            const double half_square = 0.5 * (turned_rad * turned_rad);
            const double sine_before = sine_rad;
            sine_rad = (sine_rad + turned_rad * cosine_rad) - half_square * sine_rad;
            cosine_rad = (cosine_rad - turned_rad * sine_before) - half_square * cosine_rad;
        }
    }
    velocity_rad_s_ = way_rad * steps_per_s;
    position_rad_ = x;
    if constexpr (Hangs) {
        sine_ = sine_rad * f.per_hanging_rad;
        cosine_ = cosine_rad * f.per_hanging_rad;
    }
    return sums;
}

void Plant::warm(double copper_w)
{
    const double to_case_w = (winding_c_ - case_c_) * factors_.winding_to_case_w_per_k;
    const double to_air_w = (case_c_ - parameters_.ambient_c) * factors_.case_to_ambient_w_per_k;
    winding_c_ += (copper_w - to_case_w) * factors_.winding_k_per_w;
    case_c_ += (to_case_w - to_air_w) * factors_.case_k_per_w;
}

} // namespace sinew::sim
