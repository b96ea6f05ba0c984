#include "sinew/base/units.hpp"
#include "sinew/robot/drive.hpp"
#include "sinew/robot/stillness.hpp"
#include "sinew/robot/supervisor.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

/// What was measured, and what must be done about it.
namespace sinew::robot {
namespace {

using actuator::Command;
using actuator::Mode;
using actuator::State;
using units::deg;

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

void Supervisor::observe(const State& state)
{
    if (!state.position_rad || (seen_ && seen_.at() == state.position_rad.at()))
        return;
    const TimePoint at = state.position_rad.at();
    const double gap = seen_ ? seconds(at - seen_.at()) : 0.0;
    if (state.velocity_rad_s && std::chrono::abs(at - state.velocity_rad_s.at()) <= old_velocity)
        velocity_rad_s_ = *state.velocity_rad_s;
    else if (gap > 0.0)
        velocity_rad_s_ = (*state.position_rad - *seen_) / gap;
    fastest_rad_s_ = std::max(std::abs(velocity_rad_s_), fastest_rad_s_ * std::exp2(-gap / fading_s));
    seen_ = state.position_rad;
    placed_at_ = std::max(placed_at_, at);
    see_whether_it_comes();
    // Who came back may not leave again.
    const auto& limits = rules_.limits;
    if (reach_.low_rad)
        reach_.low_rad = std::clamp(*state.position_rad, *reach_.low_rad, *limits.position_low_rad);
    if (reach_.high_rad)
        reach_.high_rad = std::clamp(*state.position_rad, *limits.position_high_rad, *reach_.high_rad);
}

double Supervisor::stopping_distance_rad(double velocity_rad_s, Duration interval) const
{
    return std::abs(velocity_rad_s) * (2.0 * seconds(interval) + seconds(rules_.stop_time) / 2.0);
}

/// Who answers without telling where he is is watched no better than who is silent. Counted up to his last answer: a
/// slow RMD tells a position in every second cycle only, and who falls silent told his before other things.
Finding Supervisor::judge_silence(const Command& running, TimePoint answered, TimePoint now) const
{
    if (now - answered > rules_.silence_max)
        return finding(
            Measure::stop, Errc::timeout,
            fmt::format("it has not answered for {:.2f} s; is its cable or its supply off?", seconds(now - answered)));
    const bool needs_place = rules_.limits.position_low_rad || rules_.limits.position_high_rad;
    if (needs_place && is_driven(running.mode) && answered - placed_at_ > rules_.silence_max)
        return finding(Measure::stop, Errc::timeout,
                       fmt::format("it answers, but has not told its position for {:.2f} s, and its limits need that; "
                                   "is its encoder at fault, or has it turned further than it can tell?",
                                   seconds(now - placed_at_)));
    return {};
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

Finding Supervisor::judge(const State& state, const Command& running, TimePoint commanded, TimePoint answered,
                          Duration interval, TimePoint now)
{
    if (auto silence = judge_silence(running, answered, now); silence.measure != Measure::none)
        return silence;
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
