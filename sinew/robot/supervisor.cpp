#include "sinew/robot/supervisor.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/drive.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace sinew::robot {
namespace {

using actuator::Command;
using actuator::Mode;
using actuator::State;
using units::deg;

bool is_between(double a, double value, double b)
{
    return std::min(a, b) <= value && value <= std::max(a, b);
}

} // namespace

Supervisor::Supervisor(std::string joint, int id, Rules rules, bool limits_velocity)
    : joint_(std::move(joint)), id_(id), rules_(std::move(rules)), limits_velocity_(limits_velocity),
      reach_{rules_.limits.position_low_rad, rules_.limits.position_high_rad}
{
}

std::unexpected<Error> Supervisor::refuse(Errc code, std::string why) const
{
    return actuator::refuse(code, id_, fmt::format("{}: {}", joint_, why));
}

Finding Supervisor::finding(Measure measure, Errc code, std::string why) const
{
    return {measure, refuse(code, std::move(why)).error()};
}

void Supervisor::begin(const State& state, TimePoint now)
{
    seen_ = {};
    placed_at_ = now;
    velocity_rad_s_ = fastest_rad_s_ = 0.0;
    too_fast_since_.reset();
    too_strong_since_.reset();
    following_ = {};
    mark_ = {};
    comes_ = false;
    stood_rad_.reset();
    reach_ = {rules_.limits.position_low_rad, rules_.limits.position_high_rad};
    reference_rad_ = state.position_rad;
    reference_at_ = now;
    is_commanded_ = false;
    allowance_rad_ = 0.0;
    observe(state);
    if (!state.position_rad)
        return;
    if (reach_.low_rad)
        reach_.low_rad = std::min(*reach_.low_rad, *state.position_rad);
    if (reach_.high_rad)
        reach_.high_rad = std::max(*reach_.high_rad, *state.position_rad);
}

// ---- commands ----

double Supervisor::allowance_rad(TimePoint now) const
{
    const double most = rules_.limits.velocity_max_rad_s.value_or(0.0);
    return std::min(allowance_rad_ + most * std::max(0.0, seconds(now - reference_at_)), most * seconds(longest_gap));
}

/// Of a position that is to be reached at once.
std::expected<void, Error> Supervisor::check_step(const Command& command, TimePoint now) const
{
    const bool at_once = command.mode == Mode::position && !command.velocity_rad_s && !command.duration;
    if (!at_once)
        return {};
    const bool is_limited = rules_.limits.step_max_rad || rules_.limits.velocity_max_rad_s;
    if (is_limited && !reference_rad_)
        return refuse(Errc::unsupported, "where it is has not been measured yet, so nothing says how far a step is");
    if (!is_limited)
        return {};
    if (leaps() && is_between(*seen_, *command.position_rad, *reference_rad_))
        return {};
    const double step = std::abs(*command.position_rad - *reference_rad_);
    if (rules_.limits.step_max_rad && step > *rules_.limits.step_max_rad + noise_rad)
        return refuse(Errc::out_of_range,
                      fmt::format("a step of {:.2f} deg from {:.2f} deg is more than the {:.2f} deg allowed; send "
                                  "smaller steps, or name a velocity",
                                  deg(step), deg(*reference_rad_), deg(*rules_.limits.step_max_rad)));
    if (!limits_velocity_ && rules_.limits.velocity_max_rad_s && step > allowance_rad(now) + noise_rad)
        return refuse(Errc::out_of_range,
                      fmt::format("a step of {:.2f} deg at once is faster than the {:.2f} deg/s allowed, by which it "
                                  "may be {:.2f} deg now; send smaller steps, or name a velocity",
                                  deg(step), deg(*rules_.limits.velocity_max_rad_s), deg(allowance_rad(now))));
    if (!limits_velocity_ && std::abs(within_lead_rad(*command.position_rad, now) - *command.position_rad) > noise_rad)
        return refuse(
            Errc::out_of_range,
            fmt::format("it is at {:.2f} deg and stays behind the {:.2f} deg that it was sent to; wait for it, "
                        "for it would leap",
                        deg(*seen_), deg(*reference_rad_)));
    return {};
}

double Supervisor::nearest_step_rad(double position_rad, TimePoint now) const
{
    if (!reference_rad_)
        return position_rad;
    double most = rules_.limits.step_max_rad.value_or(std::numeric_limits<double>::infinity());
    if (!limits_velocity_ && rules_.limits.velocity_max_rad_s)
        most = std::min(most, allowance_rad(now));
    return nearest_lead_rad(*reference_rad_ + std::clamp(position_rad - *reference_rad_, -most, most), now);
}

/// A current is a torque, and a torque takes a current.
std::expected<void, Error> Supervisor::check_push(const Command& command) const
{
    const auto& limits = rules_.limits;
    const auto& constant = rules_.torque_constant_nm_per_a;
    if (!constant)
        return {};
    const double current = std::abs(command.current_a.value_or(0.0)),
                 torque = std::abs(command.torque_nm.value_or(0.0));
    const bool has_current = command.mode == Mode::current || command.mode == Mode::velocity;
    if (has_current && limits.torque_max_nm && current * *constant > *limits.torque_max_nm + noise_rad)
        return refuse(Errc::out_of_range, fmt::format("{:g} A are {:g} Nm, more than the {:g} Nm allowed", current,
                                                      current * *constant, *limits.torque_max_nm));
    if (command.mode == Mode::torque && limits.current_max_a && torque / *constant > *limits.current_max_a + noise_rad)
        return refuse(Errc::out_of_range, fmt::format("{:g} Nm take {:g} A, more than the {:g} A allowed", torque,
                                                      torque / *constant, *limits.current_max_a));
    return {};
}

/// Of a command without end.
std::expected<void, Error> Supervisor::check_sense(const Command& command, const State& state) const
{
    const auto& limits = rules_.limits;
    if (!is_endless(command.mode) || (!limits.position_low_rad && !limits.position_high_rad))
        return {};
    if (!state.position_rad)
        return refuse(Errc::unsupported, "where it is has not been measured yet, and its limits need that");
    // A velocity that could not be stopped in time any more need not begin.
    const double on = command.mode == Mode::velocity ? seconds(rules_.stop_time) / 2.0 : 0.0;
    const double sense = sense_of(command), position = *state.position_rad + on * sense;
    if (limits.position_high_rad && sense > 0.0 && position >= *limits.position_high_rad)
        return refuse(Errc::out_of_range, fmt::format("it is at {:.2f} deg and may not go beyond {:.2f} deg; only back",
                                                      deg(*state.position_rad), deg(*limits.position_high_rad)));
    if (limits.position_low_rad && sense < 0.0 && position <= *limits.position_low_rad)
        return refuse(Errc::out_of_range, fmt::format("it is at {:.2f} deg and may not go below {:.2f} deg; only back",
                                                      deg(*state.position_rad), deg(*limits.position_low_rad)));
    return {};
}

/// Beyond a limit it may come back, a part of the way as well, but go no further than it was sent or, where it turns or
/// is free, than it is.
Supervisor::Reach Supervisor::allowed(const State& state) const
{
    Reach out{rules_.limits.position_low_rad, rules_.limits.position_high_rad};
    const std::optional<double> place = is_commanded_ ? reference_rad_ : state.position_rad.optional();
    if (place && out.low_rad)
        out.low_rad = std::min(*out.low_rad, *place);
    if (place && out.high_rad)
        out.high_rad = std::max(*out.high_rad, *place);
    return out;
}

double Supervisor::nearest_allowed_rad(double position_rad, const State& state) const
{
    const Reach reach = allowed(state);
    const double low = reach.low_rad ? std::max(*reach.low_rad, position_rad) : position_rad;
    return reach.high_rad ? std::min(*reach.high_rad, low) : low;
}

std::expected<Command, Error> Supervisor::admit(const Command& command, const State& state, TimePoint now) const
{
    actuator::Limits limits = rules_.limits;
    limits.step_max_rad.reset(); // `check_step` counts from what was sent
    const Reach reach = allowed(state);
    limits.position_low_rad = reach.low_rad;
    limits.position_high_rad = reach.high_rad;
    State from = state;
    if (reference_rad_)
        from.position_rad = {*reference_rad_, now};
    if (auto fine = actuator::check(command, limits, from, id_); !fine) {
        Error error = std::move(fine.error());
        error.detail = fmt::format("{}: {}", joint_, error.detail);
        return std::unexpected(std::move(error));
    }
    if (auto fine = check_step(command, now); !fine)
        return std::unexpected(std::move(fine.error()));
    if (auto fine = check_push(command); !fine)
        return std::unexpected(std::move(fine.error()));
    if (auto fine = check_sense(command, state); !fine)
        return std::unexpected(std::move(fine.error()));
    Command out = command;
    if (command.mode == Mode::position && !command.velocity_rad_s && !command.duration && limits_velocity_)
        out.velocity_rad_s = limits.velocity_max_rad_s;
    return out;
}

void Supervisor::sent(double position_rad, TimePoint now)
{
    refer_to(position_rad, true, now);
}

void Supervisor::follow(double position_rad, TimePoint now)
{
    refer_to(position_rad, false, now);
}

void Supervisor::catch_up(const State& state, TimePoint now)
{
    if (!is_commanded_ && state.position_rad)
        follow(*state.position_rad, now);
}

void Supervisor::refer_to(double position_rad, bool is_commanded, TimePoint now)
{
    const double step = reference_rad_ ? std::abs(position_rad - *reference_rad_) : 0.0;
    const double most = rules_.limits.velocity_max_rad_s.value_or(0.0);
    allowance_rad_ = std::max(0.0, allowance_rad(now) - step);
    // What a step leaves is not saved for a longer one, but for the unrest of a loop. Nor is the time in which no
    // position was sent, though the first one may be no step at all: the device has been given nothing to reach.
    if (step > noise_rad || !is_commanded_)
        allowance_rad_ = std::min(allowance_rad_, most * seconds(unrest));
    is_commanded_ = is_commanded;
    reference_at_ = now;
    reference_rad_ = position_rad;
}

} // namespace sinew::robot
