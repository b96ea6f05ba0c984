#include "sinew/sim/firmware/ratings.hpp"

#include "sinew/family/assumed.hpp"

namespace sinew::sim {

Rating rating_of(const sam::Spec& spec)
{
    const sam::Ratings& printed = spec.model->ratings;
    const Assumption& rest = *assumption("sam", spec.model->name);
    return {.velocity_max_rad_s = printed.max_speed_rad_s,
            .acceleration_max_rad_s2 = printed.max_torque_nm / rest.inertia_kg_m2,
            .current_max_a = printed.rated_current_a,
            .supply_v = spec.device.supply_v > 0.0 ? spec.device.supply_v : printed.rated_voltage_v,
            .temperature_c = spec.device.temperature_c};
}

Rating rating_of(const nuri::Spec& spec)
{
    const Assumption& all = *assumption("nuri", spec.model->name);
    return {.velocity_max_rad_s = all.no_load_speed_rad_s,
            .acceleration_max_rad_s2 = all.stall_torque_nm / all.inertia_kg_m2,
            .current_max_a = spec.device.rated_current_a > 0.0 ? spec.device.rated_current_a : all.stall_current_a,
            .supply_v = spec.device.supply_v > 0.0 ? spec.device.supply_v : all.rated_voltage_v};
}

Rating rating_of(const rmd::Spec& spec)
{
    const Assumption& all = *assumption("rmd", spec.model->name);
    return {.velocity_max_rad_s = all.no_load_speed_rad_s,
            .acceleration_max_rad_s2 = all.stall_torque_nm / all.inertia_kg_m2,
            .current_max_a = all.stall_current_a,
            .supply_v = spec.device.supply_v,
            .temperature_c = spec.device.temperature_c};
}

} // namespace sinew::sim
