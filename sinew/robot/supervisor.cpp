#include "sinew/robot/supervisor.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/drive.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

namespace sinew::robot {
namespace {

using actuator::Command;
using actuator::Mode;
using actuator::State;
using units::deg;

/// What is less than this beside a limit, in whatever unit, is the rounding of a conversion.
constexpr double noise_rad = 1e-9;
/// A velocity that was measured longer ago than this is worth less than what two positions say.
constexpr Duration old = std::chrono::milliseconds{30};
/// Slower than this nothing counts as on its way.
constexpr double rest_rad_s = units::rad(1.0);
/// How fast what is remembered of a velocity fades: by half in so long.
constexpr double fading_s = 0.1;

constexpr actuator::Fault serious[] = {actuator::Fault::over_temperature,
                                       actuator::Fault::driver_over_temperature,
                                       actuator::Fault::over_current,
                                       actuator::Fault::short_circuit,
                                       actuator::Fault::stall,
                                       actuator::Fault::low_voltage,
                                       actuator::Fault::high_voltage};

bool is_driven(Mode mode)
{
    return mode != Mode::release && mode != Mode::brake;
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
    velocity_rad_s_ = fastest_rad_s_ = 0.0;
    too_fast_since_.reset();
    too_strong_since_.reset();
    stuck_ = mark_ = {};
    comes_ = false;
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
    if (!limits_velocity_ && std::abs(nearest_lead_rad(*command.position_rad, now) - *command.position_rad) > noise_rad)
        return refuse(
            Errc::out_of_range,
            fmt::format("it is at {:.2f} deg and stays behind the {:.2f} deg that it was sent to; wait for it, "
                        "for it would leap",
                        deg(*seen_), deg(*reference_rad_)));
    return {};
}

/// From the measured position; it has been turning since.
double Supervisor::lead_rad(TimePoint now) const
{
    const double turned = rules_.limits.velocity_max_rad_s.value_or(0.0) * std::max(0.0, seconds(now - seen_.at()));
    return rules_.lead_max_rad.value_or(std::numeric_limits<double>::infinity()) + turned;
}

double Supervisor::nearest_lead_rad(double position_rad, TimePoint now) const
{
    if (!reference_rad_ || !seen_)
        return position_rad;
    const double most = comes_ ? lead_rad(now) / 2.0 : lead_rad(now);
    return std::clamp(position_rad, std::min(*reference_rad_, *seen_ - most), std::max(*reference_rad_, *seen_ + most));
}

bool Supervisor::is_behind(double position_rad, TimePoint now) const
{
    return seen_ && std::abs(position_rad - *seen_) > lead_rad(now);
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

std::expected<Command, Error> Supervisor::admit(const Command& command, const State& state, TimePoint now) const
{
    actuator::Limits limits = rules_.limits;
    limits.step_max_rad.reset(); // `check_step` counts from what was sent
    // Beyond a limit it may come back, a part of the way as well, but go no further than it was sent or, where it turns
    // or is free, than it is.
    const std::optional<double> place = is_commanded_ ? reference_rad_ : state.position_rad.optional();
    if (place && limits.position_low_rad)
        limits.position_low_rad = std::min(*limits.position_low_rad, *place);
    if (place && limits.position_high_rad)
        limits.position_high_rad = std::max(*limits.position_high_rad, *place);
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

// ---- measurements ----

void Supervisor::observe(const State& state)
{
    if (!state.position_rad || (seen_ && seen_.at() == state.position_rad.at()))
        return;
    const TimePoint at = state.position_rad.at();
    const double gap = seen_ ? seconds(at - seen_.at()) : 0.0;
    if (state.velocity_rad_s && std::chrono::abs(at - state.velocity_rad_s.at()) <= old)
        velocity_rad_s_ = *state.velocity_rad_s;
    else if (gap > 0.0)
        velocity_rad_s_ = (*state.position_rad - *seen_) / gap;
    fastest_rad_s_ = std::max(std::abs(velocity_rad_s_), fastest_rad_s_ * std::exp2(-gap / fading_s));
    seen_ = state.position_rad;
    see_whether_it_comes();
    // Who came back may not leave again.
    const auto& limits = rules_.limits;
    if (reach_.low_rad)
        reach_.low_rad = std::clamp(*state.position_rad, *reach_.low_rad, *limits.position_low_rad);
    if (reach_.high_rad)
        reach_.high_rad = std::clamp(*state.position_rad, *limits.position_high_rad, *reach_.high_rad);
}

/// One that gets on no more, such as under its load, is led on again as far as its lead goes.
void Supervisor::see_whether_it_comes()
{
    if (!is_commanded_ || !rules_.lead_max_rad)
        return;
    if (!mark_ || std::abs(*seen_ - *mark_) > progress_rad)
        mark_ = seen_;
    const double gap = std::abs(*reference_rad_ - *seen_);
    const bool stands = seen_.at() - mark_.at() >= lasting;
    comes_ = gap >= *rules_.lead_max_rad || (comes_ && !stands && gap > *rules_.lead_max_rad / 2.0);
}

double Supervisor::stopping_distance_rad(double velocity_rad_s, Duration interval) const
{
    return std::abs(velocity_rad_s) * (2.0 * seconds(interval) + seconds(rules_.stop_time) / 2.0);
}

Finding Supervisor::judge_faults(const State& state) const
{
    if (state.faults)
        for (const auto fault : serious)
            if (state.faults->has(fault))
                return finding(Measure::stop, Errc::unsupported,
                               fmt::format("the device reports {}; find the cause before it is used again",
                                           actuator::to_word(fault)));
    const auto& most = rules_.limits.temperature_max_c;
    if (most && state.temperature_c && *state.temperature_c >= *most)
        return finding(
            Measure::stop, Errc::out_of_range,
            fmt::format("it is {:.0f} °C hot, {:.0f} °C are allowed; let it cool", *state.temperature_c, *most));
    return {};
}

bool Supervisor::lasts(std::optional<TimePoint>& since, bool too_much, TimePoint at)
{
    if (!too_much)
        since.reset();
    else if (!since)
        since = at;
    return since && at - *since >= lasting;
}

Finding Supervisor::judge_excess(const State& state)
{
    const auto& limits = rules_.limits;
    const bool too_fast = limits.velocity_max_rad_s &&
                          std::abs(velocity_rad_s_) > *limits.velocity_max_rad_s * velocity_tolerance + rest_rad_s;
    if (lasts(too_fast_since_, too_fast, seen_.at()))
        return finding(Measure::stop, Errc::out_of_range,
                       fmt::format("it turns at {:.1f} deg/s, {:.1f} deg/s are allowed", deg(velocity_rad_s_),
                                   deg(*limits.velocity_max_rad_s)));
    const bool too_strong =
        limits.current_max_a && state.current_a && std::abs(*state.current_a) > *limits.current_max_a;
    if (state.current_a && lasts(too_strong_since_, too_strong, state.current_a.at()))
        return finding(Measure::stop, Errc::out_of_range,
                       fmt::format("it takes {:.2f} A, {:.2f} A are allowed; is it blocked?",
                                   std::abs(*state.current_a), *limits.current_max_a));
    return {};
}

/// Where it is, and where it will be when it stands still.
Finding Supervisor::judge_place(const State& state, const Command& running, Duration interval, TimePoint now) const
{
    if (!state.position_rad || !is_driven(running.mode) || !watches_place_)
        return {};
    const double position = *state.position_rad;
    const double beyond = stopping_distance_rad(fastest_rad_s_, interval) + noise_rad + units::rad(0.5);
    const bool too_low = reach_.low_rad && position < *reach_.low_rad - beyond;
    const bool too_high = reach_.high_rad && position > *reach_.high_rad + beyond;
    if (too_low || too_high)
        return finding(Measure::stop, Errc::out_of_range,
                       fmt::format("it is at {:.2f} deg, beyond its limit of {:.2f} deg by more than it needs to stop",
                                   deg(position), deg(too_low ? *reach_.low_rad : *reach_.high_rad)));
    if (!is_endless(running.mode))
        return {};
    // The next look is an interval away.
    const double on = seconds(now - state.position_rad.at() + interval) + seconds(rules_.stop_time) / 2.0;
    const double velocity = velocity_rad_s_;
    const double stands_at = position + velocity * on;
    const bool low = reach_.low_rad && velocity < 0.0 && stands_at <= *reach_.low_rad;
    const bool high = reach_.high_rad && velocity > 0.0 && stands_at >= *reach_.high_rad;
    if (low || high)
        return finding(Measure::end, Errc::out_of_range,
                       fmt::format("it has come to its limit of {:.2f} deg and holds",
                                   deg(low ? *reach_.low_rad : *reach_.high_rad)));
    return {};
}

/// Of a joint that goes at once wherever it is led.
Finding Supervisor::judge_lead(const Command& running)
{
    const bool is_led = running.mode == Mode::position && !limits_velocity_ && is_commanded_ && seen_;
    if (!is_led || !rules_.lead_max_rad || std::abs(*reference_rad_ - *seen_) < *rules_.lead_max_rad) {
        stuck_ = {};
        return {};
    }
    if (!stuck_ || std::abs(*seen_ - *stuck_) > progress_rad)
        stuck_ = seen_;
    if (seen_.at() - stuck_.at() < patience)
        return {};
    return finding(Measure::end, Errc::timeout,
                   fmt::format("it is at {:.2f} deg and does not follow to {:.2f} deg; is it blocked?", deg(*seen_),
                               deg(*reference_rad_)));
}

Finding Supervisor::judge(const State& state, const Command& running, TimePoint commanded, TimePoint answered,
                          Duration interval, TimePoint now)
{
    if (now - answered > rules_.silence_max)
        return finding(
            Measure::stop, Errc::timeout,
            fmt::format("it has not answered for {:.2f} s; is its cable or its supply off?", seconds(now - answered)));
    if (auto fault = judge_faults(state); fault.measure != Measure::none)
        return fault;
    if (is_driven(running.mode))
        if (auto excess = judge_excess(state); excess.measure != Measure::none)
            return excess;
    if (auto place = judge_place(state, running, interval, now); place.measure != Measure::none)
        return place;
    if (auto lead = judge_lead(running); lead.measure != Measure::none)
        return lead;
    const bool stands = running.mode == Mode::hold || running.mode == Mode::release || running.mode == Mode::brake;
    if (!stands && rules_.command_timeout && now - commanded > *rules_.command_timeout)
        return finding(Measure::end, Errc::timeout,
                       fmt::format("no command for {:.3f} s, {:.3f} s are allowed", seconds(now - commanded),
                                   seconds(*rules_.command_timeout)));
    return {};
}

} // namespace sinew::robot
