#include "sinew/sim/firmware/ratings.hpp"

#include "sinew/family/assumed.hpp"

namespace sinew::sim {
namespace {

/// What is known of a motor with its gearbox, from outside.
struct Figures {
    double voltage_v = 0.0;
    double stall_torque_nm = 0.0;
    double stall_current_a = 0.0;
    double no_load_rad_s = 0.0;
    double inertia_kg_m2 = 0.0; ///< of rotor and gear, at the output
};

// ASSUMED, all of these: no manual has a word on friction, gearboxes or heat.
constexpr double coulomb_share = 0.03;  // of the stall torque: a geared servo turns by hand with little force
constexpr double static_share = 0.04;   // a little more than it takes to keep it turning
constexpr double viscous_share = 0.02;  // at the no-load speed
constexpr double assumed_ratio = 100.0; // only splits one inertia between rotor and output
constexpr double warmth_k = 60.0;       // the case, with a tenth of the stall power for ever
constexpr double winding_share = 0.3;   // of that, between winding and case
constexpr double winding_time_s = 30.0;
constexpr double case_time_s = 600.0;

// Stall: T = g·I with g the torque per ampere. No load: V = K·w + R·I0 with friction g·I0, a share f of T, so that
// K = (1 - f)·V / w. The two together give the efficiency g / K that no document prints.
PlantParameters plant_from(const Figures& of)
{
    const double friction_share = coulomb_share + viscous_share;
    const double per_speed = (1.0 - friction_share) * of.voltage_v / of.no_load_rad_s;
    const double per_ampere = of.stall_torque_nm / of.stall_current_a;
    const double heat_w = 0.1 * of.voltage_v * of.stall_current_a;
    PlantParameters out;
    out.winding_ohm = of.voltage_v / of.stall_current_a;
    out.gear_ratio = assumed_ratio;
    out.torque_constant_nm_per_a = per_speed / assumed_ratio;
    out.gear_efficiency = per_ampere / per_speed;
    out.rotor_inertia_kg_m2 = of.inertia_kg_m2 / (assumed_ratio * assumed_ratio);
    out.coulomb_friction_nm = coulomb_share * of.stall_torque_nm;
    out.static_friction_nm = static_share * of.stall_torque_nm;
    out.viscous_friction_nm_s_per_rad = viscous_share * of.stall_torque_nm / of.no_load_rad_s;
    out.case_to_ambient_k_per_w = warmth_k / heat_w;
    out.winding_to_case_k_per_w = winding_share * out.case_to_ambient_k_per_w;
    out.winding_heat_capacity_j_per_k = winding_time_s / out.winding_to_case_k_per_w;
    out.case_heat_capacity_j_per_k = case_time_s / out.case_to_ambient_k_per_w;
    return out;
}

Figures figures_of(const Assumption& all)
{
    return {all.rated_voltage_v, all.stall_torque_nm, all.stall_current_a, all.no_load_speed_rad_s, all.inertia_kg_m2};
}

struct FiguresOf {
    Figures operator()(const sam::Spec& spec) const
    {
        const sam::Ratings& printed = spec.model->ratings;
        return {printed.rated_voltage_v, printed.max_torque_nm, printed.rated_current_a, printed.max_speed_rad_s,
                assumption("sam", spec.model->name)->inertia_kg_m2};
    }
    Figures operator()(const nuri::Spec& spec) const { return figures_of(*assumption("nuri", spec.model->name)); }
    Figures operator()(const rmd::Spec& spec) const { return figures_of(*assumption("rmd", spec.model->name)); }
};

} // namespace

double rated_voltage_v(const DeviceSpec& spec)
{
    return std::visit(FiguresOf{}, spec).voltage_v;
}

double supply_v(const DeviceSpec& spec)
{
    const double given = std::visit([](const auto& one) { return one.device.supply_v; }, spec);
    return given > 0.0 ? given : rated_voltage_v(spec);
}

double start_rad(const DeviceSpec& spec)
{
    return std::visit([](const auto& one) { return one.device.start_rad; }, spec);
}

PlantParameters plant_of(const DeviceSpec& spec)
{
    return plant_from(std::visit(FiguresOf{}, spec));
}

Rating rating_of(const DeviceSpec& spec)
{
    return rating_of(plant_of(spec), supply_v(spec));
}

} // namespace sinew::sim
