#include "sinew/sim/firmware/rmd_motor.hpp"

#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew::sim {
namespace {

constexpr double turn_rad = 2.0 * std::numbers::pi;

double wrapped(double rad)
{
    const double rest = std::fmod(rad, turn_rad);
    return rest < 0.0 ? rest + turn_rad : rest;
}

} // namespace

RmdMotor::RmdMotor(const rmd::Spec& spec, Plant& plant)
    : off_requires_run_(spec.profile.off_requires_run), increment_base_(spec.device.increment_base),
      encoder_steps_(1U << spec.profile.sent_encoder_bits()), plant_(plant), servo_(plant, supply_v(spec))
{
}

void RmdMotor::power_on(std::uint16_t encoder_offset, bool turns_kept)
{
    state_ = State::on;
    order_ = {};
    encoder_offset_ = encoder_offset;
    single_turn_zero_rad_ = offset_rad();
    if (!turns_kept)
        lose_turns();
    act();
}

void RmdMotor::lose_turns()
{
    multi_turn_zero_rad_ = plant_.position_rad() - wrapped(plant_.position_rad() - offset_rad());
}

// ---- orders ----

double RmdMotor::acceleration(const RmdLimits& limits) const
{
    const Rating& rating = servo_.rating();
    const double share = std::clamp(limits.current_a / rating.current_max_a, 0.0, 1.0);
    return std::min(rating.acceleration_max_rad_s2 * share, limits.acceleration_rad_s2);
}

void RmdMotor::push(double current_a)
{
    accept({.kind = Kind::torque, .value = current_a});
}

void RmdMotor::drive(double share)
{
    accept({.kind = Kind::power, .value = share});
}

void RmdMotor::turn(double velocity_rad_s, const RmdLimits& limits)
{
    accept({.kind = Kind::speed,
            .value = std::clamp(velocity_rad_s, -limits.velocity_rad_s, limits.velocity_rad_s),
            .acceleration_rad_s2 = acceleration(limits),
            .current_a = limits.current_a});
}

void RmdMotor::go_to(double multi_turn_rad, const RmdLimits& limits)
{
    accept({.kind = Kind::position,
            .value = multi_turn_zero_rad_ + multi_turn_rad,
            .velocity_rad_s = limits.velocity_rad_s,
            .acceleration_rad_s2 = acceleration(limits),
            .current_a = limits.current_a});
}

void RmdMotor::go_to_single(double single_turn_rad, bool clockwise, const RmdLimits& limits)
{
    // Less than half a step of the message is no movement, not a whole turn.
    const double nothing = units::rad(0.005);
    const double clockwise_way = wrapped(single_turn_rad - this->single_turn_rad());
    double way = clockwise ? clockwise_way : clockwise_way - turn_rad;
    if (clockwise_way < nothing || turn_rad - clockwise_way < nothing)
        way = std::remainder(clockwise_way, turn_rad);
    go_to(multi_turn_rad() + way, limits);
}

void RmdMotor::go_on(double angle_rad, const RmdLimits& limits)
{
    const bool from_target = increment_base_ == rmd::IncrementBase::target && order_.kind == Kind::position;
    const double from = from_target ? order_.value : plant_.position_rad();
    go_to(from - multi_turn_zero_rad_ + angle_rad, limits);
}

void RmdMotor::accept(const Order& order)
{
    if (state_ == State::off && off_requires_run_)
        return;
    state_ = State::on;
    order_ = order;
    act();
}

void RmdMotor::act()
{
    if (brake_engaged_) {
        servo_.brake();
        return;
    }
    if (state_ == State::stopped) {
        servo_.limit_current(servo_.rating().current_max_a);
        servo_.turn(0.0, servo_.rating().acceleration_max_rad_s2);
        return;
    }
    servo_.limit_current(order_.current_a);
    switch (order_.kind) {
    case Kind::nothing:
        servo_.release();
        break;
    case Kind::torque:
        servo_.push(order_.value);
        break;
    case Kind::power:
        servo_.drive(order_.value);
        break;
    case Kind::speed:
        servo_.turn(order_.value, order_.acceleration_rad_s2);
        break;
    case Kind::position:
        servo_.follow(order_.value, order_.velocity_rad_s, order_.acceleration_rad_s2);
        break;
    }
}

void RmdMotor::off()
{
    state_ = State::off;
    order_ = {};
    if (off_requires_run_)
        lose_turns();
    act();
}

void RmdMotor::stop()
{
    if (state_ == State::on)
        state_ = State::stopped;
    act();
}

void RmdMotor::run()
{
    state_ = State::on;
    act();
}

void RmdMotor::engage_brake(bool engaged)
{
    brake_engaged_ = engaged;
    act();
}

// ---- angles ----

double RmdMotor::offset_rad() const
{
    return encoder_offset_ * turn_rad / encoder_steps_;
}

void RmdMotor::set_encoder_offset(std::uint16_t offset)
{
    encoder_offset_ = static_cast<std::uint16_t>(offset % encoder_steps_);
    single_turn_zero_rad_ = offset_rad();
}

void RmdMotor::set_zero()
{
    single_turn_zero_rad_ = plant_.position_rad();
    set_multi_turn(0.0);
}

void RmdMotor::set_multi_turn(double multi_turn_rad)
{
    multi_turn_zero_rad_ = plant_.position_rad() - multi_turn_rad;
}

double RmdMotor::single_turn_rad() const
{
    return wrapped(plant_.position_rad() - single_turn_zero_rad_);
}

std::uint16_t RmdMotor::encoder_raw() const
{
    const auto step =
        static_cast<std::uint32_t>(std::lround(wrapped(plant_.position_rad()) / turn_rad * encoder_steps_));
    return static_cast<std::uint16_t>(step % encoder_steps_);
}

std::uint16_t RmdMotor::encoder() const
{
    return static_cast<std::uint16_t>((encoder_raw() + encoder_steps_ - encoder_offset_) % encoder_steps_);
}

std::string_view RmdMotor::mode() const
{
    constexpr std::string_view words[] = {"idle", "torque", "open-loop", "speed", "position"};
    if (brake_engaged_)
        return "brake";
    if (state_ != State::on)
        return state_ == State::off ? "off" : "stopped";
    return words[static_cast<std::size_t>(order_.kind)];
}

} // namespace sinew::sim
