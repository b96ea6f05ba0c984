#include "sinew/robot/rules.hpp"

#include "sinew/base/seconds.hpp"

#include <algorithm>

namespace sinew::robot {
namespace {

/// How far a control loop of position trails behind a steady velocity, as a time: 0.1 s in the simulator with the gains
/// of delivery, loaded or not.
constexpr double trailing_s = 0.12;

} // namespace

Rules rules_of(const config::Joint& joint, const config::Safety& safety, const actuator::Capabilities& can)
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
    rules.torque_constant_nm_per_a = can.torque_constant_nm_per_a;
    if (safety.command_timeout_s)
        rules.command_timeout = from_seconds(*safety.command_timeout_s);
    if (const auto velocity = or_else(joint.velocity_max_rad_s, can.velocity_max_rad_s)) {
        rules.trail_rad = trailing_s * *velocity;
        rules.lead_max_rad = rules.trail_rad + std::max(giving_way_rad, rules.limits.step_max_rad.value_or(0.0));
    }
    return rules;
}

} // namespace sinew::robot
