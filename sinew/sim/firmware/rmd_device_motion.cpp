#include "sinew/sim/firmware/rmd_device.hpp"

#include "sinew/base/units.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace sinew::sim {
namespace {

constexpr double angle_lsb_deg = 0.01;
constexpr double speed_lsb_dps = 0.01; // of A2 and AD
constexpr double full_power = 850.0;   // of A0

double angle_rad(std::int64_t raw)
{
    return units::rad(static_cast<double>(raw) * angle_lsb_deg);
}

double speed_rad_s(std::int32_t raw)
{
    return units::rad(raw * speed_lsb_dps);
}

} // namespace

// ---- limits (C 13; mapping to the parameters: R39) ----

RmdLimits RmdDevice::tool_limits() const
{
    using rmd::ParameterId;
    RmdLimits out;
    const auto max_speed = static_cast<std::int32_t>(ram_.parameter(ParameterId::max_speed));
    const auto max_current = static_cast<std::int16_t>(ram_.parameter(ParameterId::max_torque_current));
    out.velocity_rad_s = std::max(0.0, speed_rad_s(max_speed));
    out.current_a = max_current * iq_a_;
    // GUESS (R20): without a sensible value there is no limit but the motor's own.
    if (acceleration_dps_s_ > 0)
        out.acceleration_rad_s2 = units::rad(acceleration_dps_s_);
    return out;
}

RmdLimits RmdDevice::limits(std::uint16_t max_speed) const
{
    RmdLimits out = tool_limits();
    out.velocity_rad_s = units::rad(max_speed * spec_->profile.max_speed_lsb_dps);
    return out;
}

double RmdDevice::inside_max_angle_rad(double multi_turn_rad) const
{
    using rmd::ParameterId;
    const std::uint64_t raw = ram_.parameter(ParameterId::max_angle_low) | ram_.parameter(ParameterId::max_angle_high)
                                                                               << 32;
    if (raw == 0)
        return multi_turn_rad;
    const double most = angle_rad(static_cast<std::int64_t>(std::min<std::uint64_t>(raw, 1ULL << 62)));
    return std::clamp(multi_turn_rad, -most, most);
}

double RmdDevice::current_a(const wire::MessageInfo& message, std::string_view name, std::int64_t raw) const
{
    const std::span own(spec_->overrides.data(), spec_->override_count);
    for (const wire::Field& field : message.request.fields)
        if (field.name == name) {
            const wire::Reading reading = wire::reading(message, field, spec_->profile.line.overrides, own);
            if (reading.scale != wire::by_model)
                return reading.physical(raw);
        }
    return static_cast<double>(raw) * iq_a_;
}

// ---- torque ----

Handled<rmd::TorqueOpenLoop> RmdDevice::handle(const rmd::TorqueOpenLoop& m)
{
    motor_.drive(m.power / full_power);
    const rmd::MotorState& state = told().motor;
    return rmd::OpenLoopState{state.temperature, m.power, state.speed, state.encoder};
}

Handled<rmd::TorqueClosedLoop> RmdDevice::handle(const rmd::TorqueClosedLoop& m)
{
    motor_.push(current_a(wire::info_of<rmd::TorqueClosedLoop>, "iq", m.iq));
    return told().motor;
}

Handled<rmd::gyems::TorqueClosedLoop> RmdDevice::handle(const rmd::gyems::TorqueClosedLoop& m)
{
    motor_.push(current_a(wire::info_of<rmd::gyems::TorqueClosedLoop>, "iq_control", m.iq_control));
    return told().motor;
}

Handled<rmd::myactuator::TorqueClosedLoop> RmdDevice::handle(const rmd::myactuator::TorqueClosedLoop& m)
{
    motor_.push(current_a(wire::info_of<rmd::myactuator::TorqueClosedLoop>, "iq", m.iq));
    return told().shaft;
}

Handled<rmd::MultiMotorTorque> RmdDevice::handle(const rmd::MultiMotorTorque& m)
{
    constexpr std::array<std::string_view, 4> names = {"iq_1", "iq_2", "iq_3", "iq_4"};
    const std::array<std::int16_t, 4> raw = {m.iq_1, m.iq_2, m.iq_3, m.iq_4};
    const auto mine = static_cast<std::size_t>(id() - 1);
    motor_.push(current_a(wire::info_of<rmd::MultiMotorTorque>, names[mine], raw[mine]));
    return told().motor;
}

// ---- speed: no MaxSpeed in the manual (L828), but in LK-Tech's ----

Handled<rmd::SpeedClosedLoop> RmdDevice::handle(const rmd::SpeedClosedLoop& m)
{
    RmdLimits most = tool_limits();
    if (spec_->profile.dialect != rmd::Dialect::lk)
        most.velocity_rad_s = std::numeric_limits<double>::infinity();
    motor_.turn(speed_rad_s(m.speed), most);
    return told().motor;
}

Handled<rmd::lk::SpeedClosedLoopTorque> RmdDevice::handle(const rmd::lk::SpeedClosedLoopTorque& m)
{
    RmdLimits most = tool_limits();
    most.current_a = current_a(wire::info_of<rmd::lk::SpeedClosedLoopTorque>, "iq", m.iq);
    motor_.turn(speed_rad_s(m.speed), most);
    return told().motor;
}

Handled<rmd::lk_2_36::SpeedClosedLoop> RmdDevice::handle(const rmd::lk_2_36::SpeedClosedLoop& m)
{
    RmdLimits most = tool_limits();
    most.current_a = current_a(wire::info_of<rmd::lk_2_36::SpeedClosedLoop>, "iq", m.iq);
    motor_.turn(speed_rad_s(m.speed), most);
    return told().motor;
}

Handled<rmd::myactuator::SpeedClosedLoop> RmdDevice::handle(const rmd::myactuator::SpeedClosedLoop& m)
{
    motor_.turn(speed_rad_s(m.speed), tool_limits());
    return told().shaft;
}

// ---- position ----

Handled<rmd::MultiLoopAngle> RmdDevice::handle(const rmd::MultiLoopAngle& m)
{
    motor_.go_to(inside_max_angle_rad(angle_rad(m.angle)), tool_limits());
    return told().motor;
}

Handled<rmd::MultiLoopAngleSpeed> RmdDevice::handle(const rmd::MultiLoopAngleSpeed& m)
{
    motor_.go_to(inside_max_angle_rad(angle_rad(m.angle)), limits(m.max_speed));
    return told().motor;
}

Handled<rmd::myactuator::MultiLoopAngleSpeed> RmdDevice::handle(const rmd::myactuator::MultiLoopAngleSpeed& m)
{
    motor_.go_to(inside_max_angle_rad(angle_rad(m.angle)), limits(m.max_speed));
    return told().shaft;
}

Handled<rmd::SingleLoopAngle> RmdDevice::handle(const rmd::SingleLoopAngle& m)
{
    motor_.go_to_single(angle_rad(m.angle), m.spin_direction == rmd::Spin::clockwise, tool_limits());
    return told().motor;
}

Handled<rmd::lk::SingleLoopAngle> RmdDevice::handle(const rmd::lk::SingleLoopAngle& m)
{
    motor_.go_to_single(angle_rad(m.angle), m.spin_direction == rmd::Spin::clockwise, tool_limits());
    return told().motor;
}

Handled<rmd::SingleLoopAngleSpeed> RmdDevice::handle(const rmd::SingleLoopAngleSpeed& m)
{
    motor_.go_to_single(angle_rad(m.angle), m.spin_direction == rmd::Spin::clockwise, limits(m.max_speed));
    return told().motor;
}

Handled<rmd::lk::SingleLoopAngleSpeed> RmdDevice::handle(const rmd::lk::SingleLoopAngleSpeed& m)
{
    motor_.go_to_single(angle_rad(m.angle), m.spin_direction == rmd::Spin::clockwise, limits(m.max_speed));
    return told().motor;
}

// GUESS (R29): MaxSpeed limits A7 as well.
Handled<rmd::IncrementAngle> RmdDevice::handle(const rmd::IncrementAngle& m)
{
    motor_.go_on(angle_rad(m.angle), tool_limits());
    return told().motor;
}

Handled<rmd::IncrementAngleSpeed> RmdDevice::handle(const rmd::IncrementAngleSpeed& m)
{
    motor_.go_on(angle_rad(m.angle), limits(m.max_speed));
    return told().motor;
}

Handled<rmd::myactuator::IncrementAngleSpeed> RmdDevice::handle(const rmd::myactuator::IncrementAngleSpeed& m)
{
    motor_.go_on(angle_rad(m.angle), limits(m.max_speed));
    return told().shaft;
}

} // namespace sinew::sim
