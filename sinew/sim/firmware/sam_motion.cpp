#include "sinew/sim/firmware/sam_motion.hpp"

#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sinew::sim {
namespace {

constexpr int full_torque = 2000; // L668

std::int64_t rounded(double value, double most)
{
    return std::lround(std::clamp(value, -most, most));
}

// The ends of a boundary are those of the control range itself: 1.41° times 127 falls short of the printed 358°.
double boundary_rad(int raw, double deg_per_unit)
{
    if (raw <= 1)
        return -std::numeric_limits<double>::infinity();
    if (raw >= 254)
        return std::numeric_limits<double>::infinity();
    return units::rad((raw - sam::boundary_centre) * deg_per_unit);
}

} // namespace

SamMotion::SamMotion(const sam::Spec& spec, Plant& plant)
    : model_(spec.model), clockwise_positive_(spec.profile.clockwise_positive),
      position_ends_modes_(spec.device.position_ends_modes),
      wheel_obeys_boundaries_(spec.device.wheel_obeys_boundaries), plant_(plant),
      rating_(rating_of(plant.parameters(), supply_v(spec)))
{
    past_.fill(plant_.position_rad());
}

void SamMotion::power_on()
{
    offset_rad_ = 0.0;
    did_drive_ = false;
    past_.fill(plant_.position_rad());
    passive();
}

void SamMotion::control(bool may_drive, const SamGains& gains)
{
    now_ = (now_ + 1) % past_.size();
    past_[now_] = plant_.position_rad();
    if (drive_ == Drive::braked)
        plant_.short_circuit();
    else if (drive_ == Drive::wheel && may_drive)
        plant_.drive_duty(wheel_duty());
    else if (drive_ == Drive::position && may_drive)
        plant_.drive_duty(position_duty(gains));
    else
        plant_.open();
    did_drive_ = drive_ == Drive::position && may_drive;
}

double SamMotion::position_duty(const SamGains& gains)
{
    if (!did_drive_) {
        loop_.begin(past_[(now_ + past_.size() - 1) % past_.size()]);
        trajectory_.start(plant_.position_rad(), plant_.velocity_rad_s());
    }
    if (!is_planned_)
        return loop_.duty(target_rad_, 0.0, plant_.position_rad(), gains, duty_limit_);
    trajectory_.step();
    return loop_.duty(trajectory_.position_rad(), trajectory_.velocity_rad_s(), plant_.position_rad(), gains,
                      duty_limit_);
}

void SamMotion::go_to(double raw, const sam::PositionScale& scale, const SamBoundary& boundary,
                      double boundary_deg_per_unit, int torque, const SamRegisters& registers)
{
    if (!position_ends_modes_ && mode_ != sam::Mode::position)
        return;
    const double inside =
        std::clamp(raw, static_cast<double>(scale.control.low), static_cast<double>(scale.control.high));
    const double target = std::clamp(scale.rad(inside), boundary_rad(boundary.lower, boundary_deg_per_unit),
                                     boundary_rad(boundary.upper, boundary_deg_per_unit));
    if (registers.ctrl_torque != 0)
        torque = std::min<int>(torque, registers.ctrl_torque);
    duty_limit_ = std::min(torque, full_torque) / static_cast<double>(full_torque);
    // The sensor knows no turns: the way is that between the two angles it can tell apart.
    to(plant_.position_rad() + sense() * (target - angle_rad()), registers);
    mode_ = sam::Mode::position;
    drive_ = torque == 0 ? Drive::released : Drive::position; // "the torque does not move" (L668)
}

void SamMotion::to(double target_rad, const SamRegisters& registers)
{
    const bool planned = registers.ctrl_speed != 0 || registers.ctrl_accel != 0 || registers.ctrl_decel != 0;
    if (planned && !is_planned())
        trajectory_.start(plant_.position_rad(), plant_.velocity_rad_s());
    is_planned_ = planned;
    target_rad_ = target_rad;
    double velocity = rating_.velocity_max_rad_s;
    if (registers.ctrl_speed != 0)
        velocity = std::min(velocity, units::rad(registers.ctrl_speed * model_->speed_deg_s_per_unit));
    double acceleration = rating_.acceleration_max_rad_s2;
    for (const int limit : {registers.ctrl_accel, registers.ctrl_decel})
        if (limit != 0)
            acceleration = std::min(acceleration, units::rad(limit * model_->accel_deg_s2_per_unit));
    trajectory_.follow(target_rad, velocity, acceleration * duty_limit_);
}

void SamMotion::hold()
{
    mode_ = sam::Mode::position;
    drive_ = Drive::position;
    is_planned_ = false;
    target_rad_ = plant_.position_rad();
    duty_limit_ = 1.0;
}

void SamMotion::passive()
{
    mode_ = sam::Mode::passive;
    drive_ = Drive::released;
}

void SamMotion::brake()
{
    mode_ = sam::Mode::brake;
    drive_ = Drive::braked;
}

void SamMotion::wheel(double duty, const SamBoundary& boundary, double boundary_deg_per_unit)
{
    mode_ = sam::Mode::wheel;
    drive_ = Drive::wheel;
    wheel_duty_ = sense() * (clockwise_positive_ ? duty : -duty);
    wheel_min_rad_ = boundary_rad(boundary.lower, boundary_deg_per_unit);
    wheel_max_rad_ = boundary_rad(boundary.upper, boundary_deg_per_unit);
}

double SamMotion::wheel_duty() const
{
    const double seen_duty = sense() * wheel_duty_;
    const bool at_end = seen_duty > 0.0 ? angle_rad() >= wheel_max_rad_ : angle_rad() <= wheel_min_rad_;
    return wheel_obeys_boundaries_ && at_end ? 0.0 : wheel_duty_;
}

void SamMotion::reverse(bool on)
{
    reverse_ = on;
}

void SamMotion::offset(bool on)
{
    offset_rad_ = on ? sense() * plant_.position_rad() : 0.0;
}

double SamMotion::angle_rad() const
{
    return std::remainder(seen_rad(), 2.0 * std::numbers::pi);
}

std::int64_t SamMotion::raw_position(const sam::PositionScale& scale) const
{
    return std::clamp<std::int64_t>(std::lround(scale.raw(angle_rad())), scale.sensor.low, scale.sensor.high);
}

std::uint8_t SamMotion::turns() const
{
    return static_cast<std::uint8_t>(std::fmod(std::floor(std::abs(seen_rad()) / (2.0 * std::numbers::pi)), 255.0));
}

std::int16_t SamMotion::raw_speed() const
{
    const auto ticks = static_cast<std::size_t>(model_->speed_window / tick);
    const double before = past_[(now_ + past_.size() + 1 - ticks) % past_.size()];
    const double speed = sense() * (plant_.position_rad() - before) / seconds(model_->speed_window);
    return static_cast<std::int16_t>(rounded(units::deg(speed) / model_->speed_deg_s_per_unit, 4095));
}

std::int16_t SamMotion::raw_acceleration() const
{
    const double onward = std::copysign(1.0, plant_.velocity_rad_s());
    const double acceleration = units::deg(onward * plant_.acceleration_rad_s2());
    return static_cast<std::int16_t>(rounded(acceleration / model_->accel_deg_s2_per_unit, 1023));
}

std::uint16_t SamMotion::raw_load() const
{
    return static_cast<std::uint16_t>(rounded(std::abs(plant_.current_a()) / model_->current_a_per_ad12, 4095));
}

std::uint8_t SamMotion::raw_quick_load() const
{
    return static_cast<std::uint8_t>(rounded(std::abs(plant_.current_a()) / model_->current_a_per_ad8, 254));
}

std::uint16_t SamMotion::raw_voltage(double supply_v) const
{
    const double above = std::max(0.0, supply_v - model_->voltage_offset_v);
    return static_cast<std::uint16_t>(rounded(above / model_->voltage_v_per_ad, 4095));
}

std::string_view to_word(sam::Mode mode)
{
    return sam::modes[static_cast<std::size_t>(mode)].name;
}

} // namespace sinew::sim
