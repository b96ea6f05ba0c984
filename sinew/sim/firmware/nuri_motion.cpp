#include "sinew/sim/firmware/nuri_motion.hpp"

#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {

namespace {

// ASSUMED: the document has no law for the gains (N19). The delivered ones give the usual loop; Kp is the stiffness,
// the others work by their root, and a speed loop of its own damps even without Kd.
constexpr NuriController usual{};

ServoGains gains_of(const NuriController& controller)
{
    constexpr double own_damping = 0.5;
    return {.stiffness = controller.kp / static_cast<double>(usual.kp),
            .damping = own_damping + (1.0 - own_damping) * std::sqrt(controller.kd / static_cast<double>(usual.kd)),
            .integral = std::sqrt(controller.ki / static_cast<double>(usual.ki))};
}

} // namespace

NuriMotion::NuriMotion(const nuri::Spec& spec, Plant& plant)
    : off_keeps_target_(spec.device.off_keeps_target), position_reset_(spec.device.position_reset), plant_(plant),
      servo_(plant, supply_v(spec)), rated_current_a_(servo_.rating().current_max_a)
{
}

void NuriMotion::tune(const NuriController& controller)
{
    constexpr double current_lsb_a = 0.1;
    rated_current_a_ = std::min(controller.rated_current * current_lsb_a, servo_.rating().current_max_a);
    servo_.limit_current(rated_current_a_);
    servo_.tune(gains_of(controller));
}

double NuriMotion::acceleration() const
{
    return servo_.rating().acceleration_max_rad_s2 * rated_current_a_ / servo_.rating().current_max_a;
}

double NuriMotion::target_rad() const
{
    return order_.kind == Kind::position ? to_output(order_.value - zero_rad_) : position_rad();
}

void NuriMotion::power_on(bool on, double gear_ratio, bool inverted)
{
    on_ = on;
    ratio_ = gear_ratio;
    inverted_ = inverted;
    zero_rad_ = 0.0;
    order_ = {};
    act();
}

void NuriMotion::go_to(double position_rad, double velocity_rad_s)
{
    accept({Kind::position, zero_rad_ + to_plant(position_rad), velocity_rad_s * ratio_, acceleration()});
}

void NuriMotion::arrive(double position_rad, double time_s)
{
    const double target = zero_rad_ + to_plant(position_rad);
    const double velocity = cruise_velocity(target - plant_.position_rad(), time_s, acceleration());
    accept({Kind::position, target, velocity, acceleration()});
}

void NuriMotion::turn(double velocity_rad_s, double time_s)
{
    accept({Kind::speed, to_plant(velocity_rad_s), 0.0, acceleration(), time_s});
}

void NuriMotion::accept(const Order& order)
{
    if (!on_ && !off_keeps_target_)
        return;
    order_ = order;
    act();
}

void NuriMotion::control(bool on)
{
    if (on == on_)
        return;
    on_ = on;
    if (!on)
        order_ = {};
    act();
}

// The order of before goes on in its own sense until the next one.
void NuriMotion::invert(bool on)
{
    inverted_ = on;
}

void NuriMotion::reset_position()
{
    if (position_reset_ == nuri::PositionReset::here_is_zero)
        zero_rad_ = plant_.position_rad();
    else
        go_to(0.0, to_output(servo_.rating().velocity_max_rad_s));
}

void NuriMotion::act()
{
    if (!on_)
        servo_.release();
    else if (order_.kind == Kind::position)
        servo_.follow(order_.value, order_.velocity_rad_s, order_.acceleration_rad_s2);
    else
        servo_.turn(order_.kind == Kind::speed ? order_.value : 0.0,
                    order_.kind == Kind::speed ? order_.acceleration_rad_s2 : acceleration(), order_.after_s);
}

std::string_view NuriMotion::mode() const
{
    constexpr std::string_view words[] = {"hold", "position", "speed"};
    return on_ ? words[static_cast<std::size_t>(order_.kind)] : "off";
}

} // namespace sinew::sim
