#include "sinew/robot/rules.hpp"

#include "sinew/base/seconds.hpp"

namespace sinew::robot {

Rules rules_of(const config::Joint& joint, const config::Safety& safety)
{
    const auto or_else = [](const std::optional<double>& own, const std::optional<double>& common) {
        return own ? own : common;
    };
    Rules rules{.limits = {.position_low_rad = joint.position_min_rad,
                           .position_high_rad = joint.position_max_rad,
                           .velocity_max_rad_s = joint.velocity_max_rad_s,
                           .current_max_a = or_else(joint.current_max_a, safety.current_max_a),
                           .torque_max_nm = joint.torque_max_nm,
                           .step_max_rad = or_else(joint.step_max_rad, safety.step_max_rad),
                           .temperature_max_c = or_else(joint.temperature_max_c, safety.temperature_max_c)},
                .silence_max = from_seconds(safety.silence_max_s),
                .stop_time = from_seconds(joint.stop_time_s.value_or(safety.stop_time_s))};
    if (safety.command_timeout_s)
        rules.command_timeout = from_seconds(*safety.command_timeout_s);
    return rules;
}

} // namespace sinew::robot
