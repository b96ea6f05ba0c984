#pragma once
#include "sinew/base/time.hpp"

#include <cstdint>
#include <limits>

namespace sinew::sim {

/// The step of the physics, and how many of them make the tick of firmware and supply.
inline constexpr Duration plant_step = std::chrono::microseconds{100};
inline constexpr double plant_step_s = 1e-4;
inline constexpr int steps_per_tick = 10;
inline constexpr Duration tick = steps_per_tick * plant_step;
inline constexpr double tick_s = steps_per_tick * plant_step_s;

/// What an actuator and its load are made of. The motor's values are those of the motor shaft, all others those of the
/// output shaft. Every field is a key of `[joint.NAME.plant]`.
struct PlantParameters {
    // The motor: its voltage constant in V·s/rad is the same number as its torque constant in N·m/A.
    double winding_ohm = 1.0;
    double torque_constant_nm_per_a = 0.1;
    double rotor_inertia_kg_m2 = 1e-5;
    // The gearbox.
    double gear_ratio = 1.0;
    double gear_efficiency = 1.0; ///< of the torque it passes on, either way
    // Friction of all that turns.
    double viscous_friction_nm_s_per_rad = 0.0;
    double coulomb_friction_nm = 0.0; ///< while it turns
    double static_friction_nm = 0.0;  ///< what it takes to start it; not below the Coulomb friction
    // The load.
    double load_inertia_kg_m2 = 0.0;
    double external_torque_nm = 0.0; ///< constant, in the positive sense
    double gravity_torque_nm = 0.0;  ///< the greatest that the hanging load gives: mass · g · distance
    double gravity_zero_rad = 0.0;   ///< where the load hangs down at rest
    double stop_min_rad = -std::numeric_limits<double>::infinity(); ///< hard stops, which take all the speed
    double stop_max_rad = std::numeric_limits<double>::infinity();
    // Heat: copper losses warm the winding, the winding the case, the case the air.
    double winding_heat_capacity_j_per_k = 20.0;
    double winding_to_case_k_per_w = 1.0;
    double case_heat_capacity_j_per_k = 200.0;
    double case_to_ambient_k_per_w = 3.0;
    double ambient_c = 25.0;

    double inertia_kg_m2() const { return load_inertia_kg_m2 + gear_ratio * gear_ratio * rotor_inertia_kg_m2; }
    /// Torque constant times ratio: volts of back-EMF for each rad/s of the output.
    double voltage_constant_v_s_per_rad() const { return gear_ratio * torque_constant_nm_per_a; }
    /// Torque at the output for each ampere while the motor drives.
    double torque_per_ampere_nm() const { return gear_efficiency * voltage_constant_v_s_per_rad(); }
};

/// A motor with its gearbox, its load and its heat: physics that knows no protocol. Moved on in steps of `plant_step`
/// by semi-implicit Euler, ten of them a call, the same on every machine; no heap.
///
/// The winding has no inductance: the current follows the voltage at once. The resistance does not change with heat.
/// Positive is whatever its user calls so. Positions are not wrapped.
class Plant
{
public:
    explicit Plant(const PlantParameters& parameters, double position_rad = 0.0);

    // ---- how the motor is driven, until told otherwise ----

    void open();                          ///< terminals open: no current
    void short_circuit();                 ///< terminals shorted: dynamic braking
    void drive_duty(double duty);         ///< -1 … 1 of the supply voltage; beyond it is cut
    void drive_current(double current_a); ///< a fast current loop, as far as the supply voltage allows

    /// Moves on by `tick` at this supply voltage.
    void run(double supply_v);

    // ---- what the world does to it ----

    void push(double torque_nm) { pushed_nm_ = torque_nm; } ///< external torque on top of the constant one
    void jam(bool jammed) { jammed_ = jammed; }             ///< a gear that is stuck
    void heat_to(double temperature_c) { winding_c_ = case_c_ = temperature_c; }

    double position_rad() const { return position_rad_; }
    double velocity_rad_s() const { return velocity_rad_s_; }
    double acceleration_rad_s2() const { return acceleration_rad_s2_; } ///< mean of the last tick
    double current_a() const { return current_a_; }                     ///< of the winding, mean of the last tick
    double supply_current_a() const { return supply_current_a_; } ///< mean of the last tick; below 0 it feeds back
    double external_nm() const { return parameters_.external_torque_nm + pushed_nm_; }
    double winding_c() const { return winding_c_; }
    double case_c() const { return case_c_; }
    const PlantParameters& parameters() const { return parameters_; }

private:
    enum class Drive : std::uint8_t { open, duty, current };

    /// What one step needs of the parameters, so that no step divides. Torques stand as what they add in one step to
    /// the way of a step: `_rad` is dt² / J · torque.
    struct Factors {
        /// Which way power goes through the gearbox decides what it costs.
        struct Way {
            double nm_per_a = 0.0;
            double rad_per_v = 0.0;   ///< of the voltage at the terminals
            double shrink_duty = 1.0; ///< 1 / (1 + dt/J · damping) of a motor driven by its voltage
        };

        explicit Factors(const PlantParameters& p);

        double per_ohm;
        double v_s_per_rad;
        double rad_per_nm;
        double kinetic_rad; ///< Coulomb friction
        double static_rad;
        double hanging_rad;     ///< gravity at its greatest
        double per_hanging_rad; ///< 0 without gravity
        double shrink = 1.0;    ///< 1 / (1 + dt/J · viscous friction)
        Way driving;
        Way driven_back;
        double winding_k_per_w; ///< in one tick
        double case_k_per_w;
        double winding_to_case_w_per_k;
        double case_to_ambient_w_per_k;
    };

    struct Sums;

    void look_at_the_angle();
    double load_torque() const;
    template <Drive D, bool Hangs>
    Sums turn(double supply_v);
    Sums turn(double supply_v);
    void rest(double supply_v, double current_a);
    void warm(double copper_w);

    PlantParameters parameters_;
    Factors factors_;
    Drive drive_ = Drive::open;
    bool jammed_ = false;
    double driven_ = 0.0; ///< duty or current, as `drive_` says
    double pushed_nm_ = 0.0;
    double position_rad_ = 0.0;
    double velocity_rad_s_ = 0.0;
    double acceleration_rad_s2_ = 0.0;
    double current_a_ = 0.0;
    double supply_current_a_ = 0.0;
    double winding_c_ = 25.0;
    double case_c_ = 25.0;
    // Of the angle from where the load hangs down; worked out anew when the shaft has gone a little way.
    double sine_ = 0.0;
    double cosine_ = 1.0;
    double looked_at_rad_ = std::numeric_limits<double>::infinity(); ///< where that was
};

} // namespace sinew::sim
