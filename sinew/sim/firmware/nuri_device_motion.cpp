#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/nuri_device.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

constexpr double position_lsb_deg = 0.01;    // modes 1, 2, 0xD1
constexpr double far_position_lsb_deg = 0.1; // mode 0xD2 (N06)
constexpr double speed_lsb_rpm = 0.1;
constexpr double time_lsb_s = 0.1;
constexpr double current_lsb_a = 0.1;
constexpr std::int64_t largest = 65533; // N04

double speed_rad_s(std::uint16_t raw)
{
    return units::rad_s_from_rpm(raw * speed_lsb_rpm);
}

} // namespace

// ---- sign and magnitude (N16) ----

double NuriDevice::sense(nuri::Rotation direction) const
{
    return (direction == nuri::Rotation::counter_clockwise) == spec_.profile.ccw_positive ? 1.0 : -1.0;
}

// GUESS (N35): 0 has the direction byte 0.
nuri::Rotation NuriDevice::direction_of(double value) const
{
    const bool counter_clockwise = value == 0.0 || (value > 0.0) == spec_.profile.ccw_positive;
    return counter_clockwise ? nuri::Rotation::counter_clockwise : nuri::Rotation::clockwise;
}

double NuriDevice::target_rad(nuri::Rotation direction, std::uint16_t position) const
{
    const double angle = sense(direction) * units::rad(position * position_lsb_deg);
    if (!stored_.used.relative)
        return angle;
    const bool from_target = spec_.device.relative_base == nuri::RelativeBase::target;
    return angle + (from_target ? motion_.target_rad() : motion_.position_rad());
}

// ---- motion ----

bool NuriDevice::handle(const nuri::PositionSpeedControl& m)
{
    motion_.tune(stored_.used.position);
    motion_.go_to(target_rad(m.position_direction, m.position), speed_rad_s(m.speed));
    return true;
}

bool NuriDevice::handle(const nuri::AccelPositionControl& m)
{
    motion_.tune(stored_.used.position);
    motion_.arrive(target_rad(m.position_direction, m.position), m.arrival_time * time_lsb_s);
    return true;
}

bool NuriDevice::handle(const nuri::AccelSpeedControl& m)
{
    motion_.tune(stored_.used.speed);
    motion_.turn(sense(m.speed_direction) * speed_rad_s(m.speed), m.arrival_time * time_lsb_s);
    return true;
}

bool NuriDevice::handle(const nuri::ResetPosition&)
{
    motion_.reset_position();
    return true;
}

bool NuriDevice::handle(const nuri::mc::ResetPosition&)
{
    motion_.reset_position();
    return true;
}

// ---- feedback ----

std::uint16_t NuriDevice::raw_position(double lsb_deg) const
{
    const auto raw = std::llround(std::abs(units::deg(motion_.position_rad())) / lsb_deg);
    if (spec_.profile.position_feedback_limit == nuri::PositionFeedbackLimit::wrap)
        return static_cast<std::uint16_t>(raw % (largest + 1));
    return static_cast<std::uint16_t>(std::min<std::int64_t>(raw, largest));
}

std::uint16_t NuriDevice::raw_speed() const
{
    const auto raw = std::llround(std::abs(units::rpm(motion_.velocity_rad_s())) / speed_lsb_rpm);
    return static_cast<std::uint16_t>(std::min<std::int64_t>(raw, largest));
}

std::uint8_t NuriDevice::raw_current() const
{
    const auto raw = std::llround(std::abs(motion_.current_a()) / current_lsb_a);
    return static_cast<std::uint8_t>(std::min<std::int64_t>(raw, 254));
}

nuri::ReplyPing NuriDevice::handle(const nuri::RequestPing&)
{
    return {};
}

nuri::ReplyPositionFeedback NuriDevice::handle(const nuri::RequestPositionFeedback&)
{
    const std::uint16_t position = raw_position(position_lsb_deg);
    return {direction_of(position == 0 ? 0.0 : motion_.position_rad()), position, raw_speed(), raw_current()};
}

nuri::ReplySpeedFeedback NuriDevice::handle(const nuri::RequestSpeedFeedback&)
{
    const std::uint16_t speed = raw_speed();
    return {direction_of(speed == 0 ? 0.0 : motion_.velocity_rad_s()), speed, raw_position(far_position_lsb_deg),
            raw_current()};
}

nuri::ReplyPositionControllerFeedback NuriDevice::handle(const nuri::RequestPositionControllerFeedback&)
{
    const NuriController& c = stored_.used.position;
    return {c.kp, c.ki, c.kd, c.rated_current};
}

nuri::ReplySpeedControllerFeedback NuriDevice::handle(const nuri::RequestSpeedControllerFeedback&)
{
    const NuriController& c = stored_.used.speed;
    return {c.kp, c.ki, c.kd, c.rated_current};
}

nuri::ReplyResponseTimeFeedback NuriDevice::handle(const nuri::RequestResponseTimeFeedback&)
{
    return {stored_.used.response_time};
}

nuri::ReplyGearRatioFeedback NuriDevice::handle(const nuri::RequestGearRatioFeedback&)
{
    return {stored_.used.gear_ratio};
}

nuri::mc::ReplyGearRatioFeedback NuriDevice::handle(const nuri::mc::RequestGearRatioFeedback&)
{
    return {stored_.used.gear_ratio};
}

nuri::ReplyControlOnOffFeedback NuriDevice::handle(const nuri::RequestControlOnOffFeedback&)
{
    return {stored_.used.on ? nuri::Control::on : nuri::Control::off};
}

nuri::mc::ReplyControlOnOffFeedback NuriDevice::handle(const nuri::mc::RequestControlOnOffFeedback&)
{
    return {stored_.used.on ? nuri::Control::on : nuri::Control::off};
}

nuri::ReplyPositionModeFeedback NuriDevice::handle(const nuri::RequestPositionModeFeedback&)
{
    return {stored_.used.relative ? nuri::PositionMode::relative : nuri::PositionMode::absolute};
}

nuri::mc::ReplyPositionModeFeedback NuriDevice::handle(const nuri::mc::RequestPositionModeFeedback&)
{
    return {stored_.used.relative ? nuri::PositionMode::relative : nuri::PositionMode::absolute};
}

nuri::mc::ReplyControlDirectionFeedback NuriDevice::handle(const nuri::mc::RequestControlDirectionFeedback&)
{
    return {stored_.used.inverted ? nuri::Rotation::clockwise : nuri::Rotation::counter_clockwise};
}

nuri::mc::ReplyRatedSpeedFeedback NuriDevice::handle(const nuri::mc::RequestRatedSpeedFeedback&)
{
    return {stored_.used.rated_speed};
}

nuri::mc::ReplyResolutionFeedback NuriDevice::handle(const nuri::mc::RequestResolutionFeedback&)
{
    return {stored_.used.resolution};
}

nuri::ReplyFirmwareVersionFeedback NuriDevice::handle(const nuri::RequestFirmwareVersionFeedback&)
{
    return {0}; // of the document's example
}

} // namespace sinew::sim
