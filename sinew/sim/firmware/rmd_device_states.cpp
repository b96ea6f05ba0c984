#include "sinew/sim/firmware/rmd_device.hpp"

#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::sim {
namespace {

constexpr std::uint8_t motor_is_off = 0x10;

template <class T>
T saturated(double value)
{
    return static_cast<T>(std::llround(std::clamp(value, static_cast<double>(std::numeric_limits<T>::min()),
                                                  static_cast<double>(std::numeric_limits<T>::max()))));
}

std::int64_t centidegrees(double rad)
{
    return std::llround(units::deg(rad) * 100.0);
}

std::uint16_t circle_angle(double rad)
{
    return static_cast<std::uint16_t>(centidegrees(rad) % 36'000);
}

} // namespace

// ---- angles and their zero ----

Handled<rmd::ReadEncoder> RmdDevice::handle(const rmd::ReadEncoder&)
{
    return rmd::Encoder{motor_.encoder(), motor_.encoder_raw(), motor_.encoder_offset()};
}

Handled<rmd::WriteEncoderOffset> RmdDevice::handle(const rmd::WriteEncoderOffset& m)
{
    rom_.encoder_offset = m.encoder_offset;
    if (spec_->device.encoder_offset_effect == rmd::OffsetEffect::at_once)
        motor_.set_encoder_offset(m.encoder_offset);
    return rmd::EncoderOffset{m.encoder_offset};
}

// Effective after the next power-on only (L419-449).
Handled<rmd::WriteCurrentPositionZeroRom> RmdDevice::handle(const rmd::WriteCurrentPositionZeroRom&)
{
    rom_.encoder_offset = motor_.encoder_raw();
    return rmd::EncoderOffset{rom_.encoder_offset};
}

Handled<rmd::ReadMultiTurnAngle> RmdDevice::handle(const rmd::ReadMultiTurnAngle&)
{
    return rmd::MultiTurnAngle{centidegrees(motor_.multi_turn_rad())};
}

Handled<rmd::myactuator::ReadMultiTurnAngle> RmdDevice::handle(const rmd::myactuator::ReadMultiTurnAngle&)
{
    return rmd::myactuator::MultiTurnAngle{saturated<std::int32_t>(units::deg(motor_.multi_turn_rad()) * 100.0)};
}

Handled<rmd::ReadSingleTurnAngle> RmdDevice::handle(const rmd::ReadSingleTurnAngle&)
{
    return rmd::SingleTurnAngle{circle_angle(motor_.single_turn_rad())};
}

Handled<rmd::lk::ReadSingleTurnAngle> RmdDevice::handle(const rmd::lk::ReadSingleTurnAngle&)
{
    return rmd::lk::SingleTurnAngle{circle_angle(motor_.single_turn_rad())};
}

Handled<rmd::SetCurrentPositionZero> RmdDevice::handle(const rmd::SetCurrentPositionZero&)
{
    motor_.set_zero();
    return rmd::Acknowledged{};
}

Handled<rmd::lk::SetCurrentAngle> RmdDevice::handle(const rmd::lk::SetCurrentAngle& m)
{
    motor_.set_multi_turn(units::rad(m.angle * 0.01));
    return rmd::Acknowledged{};
}

// ---- states ----

std::int8_t RmdDevice::temperature() const
{
    return saturated<std::int8_t>(plant_.winding_c());
}

std::int16_t RmdDevice::speed_dps() const
{
    return saturated<std::int16_t>(units::deg(plant_.velocity_rad_s()));
}

std::int16_t RmdDevice::iq() const
{
    const double raw = plant_.current_a() / iq_a_;
    if (spec_->profile.iq_in_centiamperes)
        return saturated<std::int16_t>(raw);
    const double most = spec_->model->iq == rmd::Iq::power ? 1000.0 : 2048.0;
    return saturated<std::int16_t>(std::clamp(raw, -most, most));
}

std::uint8_t RmdDevice::errors() const
{
    const bool low = supply_v() < spec_->device.low_voltage_v;
    const bool high = supply_v() > spec_->device.over_voltage_v;
    const bool hot = plant_.winding_c() >= spec_->device.temperature_limit_c;
    return static_cast<std::uint8_t>((low ? rmd_low_voltage : 0) | (high ? rmd_high_voltage : 0) |
                                     (hot ? rmd_over_temperature : 0));
}

// The manual calls the other bits invalid (L567-574).
std::uint8_t RmdDevice::told_errors() const
{
    const bool two = spec_->profile.error_bits == rmd::ErrorBits::two;
    return two ? latched_errors_ & (rmd_low_voltage | rmd_over_temperature) : latched_errors_;
}

RmdDevice::Moment RmdDevice::moment() const
{
    const auto turned = saturated<std::int16_t>(units::deg(motor_.multi_turn_rad()));
    return {.motor = {temperature(), iq(), speed_dps(), motor_.encoder()},
            .shaft = {temperature(), iq(), speed_dps(), turned}};
}

rmd::Status1 RmdDevice::status1() const
{
    const double voltage = supply_v() / spec_->profile.voltage_lsb_v;
    return {temperature(), saturated<std::uint16_t>(voltage), told_errors()};
}

rmd::lk::Status1 RmdDevice::lk_status1() const
{
    const double voltage = supply_v() / spec_->profile.voltage_lsb_v;
    return {temperature(), saturated<std::int16_t>(voltage), saturated<std::int16_t>(plant_.current_a() / 0.01),
            motor_.is_off() ? motor_is_off : std::uint8_t{0}, told_errors()};
}

Handled<rmd::ReadStatus1> RmdDevice::handle(const rmd::ReadStatus1&)
{
    return status1();
}

Handled<rmd::lk::ReadStatus1> RmdDevice::handle(const rmd::lk::ReadStatus1&)
{
    return lk_status1();
}

Handled<rmd::lk_2_36::ReadStatus1> RmdDevice::handle(const rmd::lk_2_36::ReadStatus1&)
{
    return lk_status1();
}

// The meaning of its 16 error bits is in no document at hand, so none is ever set.
Handled<rmd::myactuator::ReadStatus1> RmdDevice::handle(const rmd::myactuator::ReadStatus1&)
{
    const rmd::Status1 common = status1();
    return rmd::myactuator::Status1{common.temperature, !motor_.brake_engaged(), common.voltage, 0};
}

// A flag stays while its cause does (L608).
Handled<rmd::ClearError> RmdDevice::handle(const rmd::ClearError&)
{
    latched_errors_ = errors();
    return status1();
}

Handled<rmd::lk::ClearError> RmdDevice::handle(const rmd::lk::ClearError&)
{
    latched_errors_ = errors();
    return lk_status1();
}

Handled<rmd::lk_2_36::ClearError> RmdDevice::handle(const rmd::lk_2_36::ClearError&)
{
    latched_errors_ = errors();
    return lk_status1();
}

Handled<rmd::ReadStatus2> RmdDevice::handle(const rmd::ReadStatus2&)
{
    return moment().motor;
}

Handled<rmd::myactuator::ReadStatus2> RmdDevice::handle(const rmd::myactuator::ReadStatus2&)
{
    return moment().shaft;
}

// ASSUMED: the rotor always stands where phase A carries the whole torque current.
rmd::PhaseCurrents RmdDevice::phase_currents() const
{
    const double given = spec_->phase_current_a();
    const double raw = plant_.current_a() / (given > 0.0 ? given : iq_a_);
    const auto other = saturated<std::int16_t>(-raw / 2.0);
    return {saturated<std::int16_t>(raw), other, other};
}

Handled<rmd::ReadStatus3> RmdDevice::handle(const rmd::ReadStatus3&)
{
    return phase_currents();
}

Handled<rmd::lk::ReadStatus3> RmdDevice::handle(const rmd::lk::ReadStatus3&)
{
    const rmd::PhaseCurrents i = phase_currents();
    return rmd::lk::PhaseCurrents{temperature(), i.phase_a_current, i.phase_b_current, i.phase_c_current};
}

Handled<rmd::myactuator::ReadStatus3> RmdDevice::handle(const rmd::myactuator::ReadStatus3&)
{
    const rmd::PhaseCurrents i = phase_currents();
    return rmd::myactuator::PhaseCurrents{temperature(), i.phase_a_current, i.phase_b_current, i.phase_c_current};
}

// ---- on, off, brake ----

Handled<rmd::MotorOff> RmdDevice::handle(const rmd::MotorOff&)
{
    motor_.off();
    return rmd::Acknowledged{};
}

Handled<rmd::MotorStop> RmdDevice::handle(const rmd::MotorStop&)
{
    motor_.stop();
    return rmd::Acknowledged{};
}

Handled<rmd::MotorRunning> RmdDevice::handle(const rmd::MotorRunning&)
{
    motor_.run();
    return rmd::Acknowledged{};
}

Handled<rmd::lk::BrakeControl> RmdDevice::handle(const rmd::lk::BrakeControl& m)
{
    constexpr std::uint8_t engage = 0;
    constexpr std::uint8_t release = 1;
    if (m.brake == engage || m.brake == release)
        motor_.engage_brake(m.brake == engage);
    return rmd::lk::BrakeState{motor_.brake_engaged() ? engage : release};
}

Handled<rmd::myactuator::BrakeRelease> RmdDevice::handle(const rmd::myactuator::BrakeRelease&)
{
    motor_.engage_brake(false);
    return rmd::Acknowledged{};
}

Handled<rmd::myactuator::BrakeLock> RmdDevice::handle(const rmd::myactuator::BrakeLock&)
{
    motor_.engage_brake(true);
    return rmd::Acknowledged{};
}

Handled<rmd::myactuator::SystemReset> RmdDevice::handle(const rmd::myactuator::SystemReset&)
{
    power_on();
    return wire::Nothing{};
}

} // namespace sinew::sim
