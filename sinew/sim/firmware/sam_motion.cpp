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
    : model_(spec.model), clockwise_positive_(spec.profile.clockwise_positive), plant_(plant),
      servo_(plant, supply_v(spec))
{
    past_.fill(plant_.position_rad());
}

void SamMotion::power_on()
{
    offset_rad_ = 0.0;
    passive();
}

void SamMotion::control()
{
    now_ = (now_ + 1) % past_.size();
    past_[now_] = plant_.position_rad();
    if (too_hot() && mode_ == sam::Mode::position)
        servo_.release(); // L714
    servo_.control();
}

void SamMotion::go_to(double raw, const sam::PositionScale& scale, const SamBoundary& boundary,
                      double boundary_deg_per_unit, int torque, const SamRegisters& registers)
{
    mode_ = sam::Mode::position;
    const double inside =
        std::clamp(raw, static_cast<double>(scale.control.low), static_cast<double>(scale.control.high));
    const double target = std::clamp(scale.rad(inside), boundary_rad(boundary.lower, boundary_deg_per_unit),
                                     boundary_rad(boundary.upper, boundary_deg_per_unit));
    if (registers.ctrl_torque != 0)
        torque = std::min<int>(torque, registers.ctrl_torque);
    if (torque == 0) { // "the torque does not move" (L668)
        servo_.release();
        return;
    }
    const Rating& rating = servo_.rating();
    double velocity = rating.velocity_max_rad_s;
    if (registers.ctrl_speed != 0)
        velocity = units::rad(registers.ctrl_speed * model_->speed_deg_s_per_unit);
    double acceleration = rating.acceleration_max_rad_s2 * std::min(torque, full_torque) / full_torque;
    for (const int limit : {registers.ctrl_accel, registers.ctrl_decel})
        if (limit != 0)
            acceleration = std::min(acceleration, units::rad(limit * model_->accel_deg_s2_per_unit));
    // The sensor knows no turns: the way is that between the two angles it can tell apart.
    servo_.follow(plant_.position_rad() + sense() * (target - angle_rad()), velocity, acceleration);
}

void SamMotion::hold()
{
    mode_ = sam::Mode::position;
    servo_.turn(0.0, servo_.rating().acceleration_max_rad_s2);
}

void SamMotion::passive()
{
    mode_ = sam::Mode::passive;
    servo_.release();
}

void SamMotion::brake()
{
    mode_ = sam::Mode::brake;
    servo_.brake();
}

void SamMotion::wheel(double duty)
{
    mode_ = sam::Mode::wheel;
    const double clockwise = clockwise_positive_ ? 1.0 : -1.0;
    servo_.turn(sense() * clockwise * duty * servo_.rating().velocity_max_rad_s,
                servo_.rating().acceleration_max_rad_s2);
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
    const auto steps = static_cast<std::size_t>(model_->speed_window / plant_step);
    const double before = past_[(now_ + past_.size() - steps) % past_.size()];
    const double speed = sense() * (plant_.position_rad() - before) / seconds(model_->speed_window);
    return static_cast<std::int16_t>(rounded(units::deg(speed) / model_->speed_deg_s_per_unit, 4095));
}

std::int16_t SamMotion::raw_acceleration() const
{
    const double acceleration = units::deg(sense() * plant_.acceleration_rad_s2());
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

bool SamMotion::too_hot() const
{
    return plant_.case_c() >= sam::overheat_c;
}

std::string_view to_word(sam::Mode mode)
{
    return sam::modes[static_cast<std::size_t>(mode)].name;
}

} // namespace sinew::sim
