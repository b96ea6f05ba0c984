#include "sinew/robot/mounting.hpp"

#include <utility>

namespace sinew::robot {
namespace {

void scale(std::optional<double>& value, double by)
{
    if (value)
        *value *= by;
}

actuator::Measured<double> scaled(const actuator::Measured<double>& value, double by)
{
    return value ? actuator::Measured<double>(*value * by, value.at()) : value;
}

} // namespace

Mounting Mounting::of(const config::Joint& joint)
{
    return {.direction = static_cast<double>(joint.direction), .ratio = joint.ratio, .zero_rad = joint.zero_rad};
}

actuator::Command Mounting::to_actuator(const actuator::Command& command) const
{
    using actuator::Mode;
    actuator::Command out = command;
    if (command.position_rad)
        out.position_rad = to_actuator(*command.position_rad);
    // Elsewhere than in their own modes velocity and current are limits without a sense.
    scale(out.velocity_rad_s, command.mode == Mode::velocity ? direction * ratio : ratio);
    if (command.mode == Mode::current)
        scale(out.current_a, direction);
    scale(out.torque_nm, direction / ratio);
    scale(out.duty, direction);
    scale(out.resolution_rad, ratio);
    return out;
}

actuator::State Mounting::to_joint(const actuator::State& state, bool signed_current) const
{
    actuator::State out = state;
    if (state.position_rad)
        out.position_rad = {to_joint(*state.position_rad), state.position_rad.at()};
    out.velocity_rad_s = scaled(state.velocity_rad_s, direction / ratio);
    if (signed_current)
        out.current_a = scaled(state.current_a, direction);
    return out;
}

actuator::Capabilities Mounting::to_joint(const actuator::Capabilities& can) const
{
    actuator::Capabilities out = can;
    const auto place = [&](const std::optional<double>& rad) {
        return rad ? std::optional(to_joint(*rad)) : std::nullopt;
    };
    out.position_low_rad = place(can.position_low_rad);
    out.position_high_rad = place(can.position_high_rad);
    if (direction < 0.0)
        std::swap(out.position_low_rad, out.position_high_rad);
    out.position_step_rad /= ratio;
    scale(out.velocity_max_rad_s, 1.0 / ratio);
    scale(out.torque_constant_nm_per_a, ratio);
    return out;
}

} // namespace sinew::robot
