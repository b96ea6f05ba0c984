#include "sinew/robot/joint.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/robot/hold_unseen.hpp"
#include "sinew/robot/pressing.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

namespace sinew::robot {
namespace {

Mode mode_of(config::Policy policy)
{
    switch (policy) {
    case config::Policy::release:
        return Mode::release;
    case config::Policy::brake:
        return Mode::brake;
    case config::Policy::hold:
        break;
    }
    return Mode::hold;
}

/// What a device knows of its position after power-on.
bool is_absolute(const ResolvedJoint& joint)
{
    if (std::holds_alternative<sam::Spec>(joint.device))
        return true;
    const auto* motor = std::get_if<rmd::Spec>(&joint.device);
    const auto& file = *joint.joint;
    if (motor == nullptr || !file.position_min_rad || !file.position_max_rad)
        return false;
    // R38: the angle begins within the first turn of the shaft that is counted, so all of the range must lie there.
    const Mounting mounting = Mounting::of(file);
    const auto is_first_turn = [&](double joint_rad) {
        const double counted = mounting.to_actuator(joint_rad) * motor->profile.gear_ratio;
        return counted >= 0.0 && counted <= 2.0 * std::numbers::pi;
    };
    return is_first_turn(*file.position_min_rad) && is_first_turn(*file.position_max_rad);
}

} // namespace

Joint::Joint(const ResolvedJoint& resolved, const config::RobotFile& file, const link::Clock& clock,
             Incidents& incidents)
    : resolved_(&resolved), clock_(&clock), incidents_(&incidents), mounting_(Mounting::of(*resolved.joint)),
      driver_(make_driver(resolved.device)), stopper_(make_driver(resolved.device)),
      can_(mounting_.to_joint(driver_->capabilities())),
      guard_(resolved.joint->name, id_of(resolved.device), rules_of(*resolved.joint, file.safety, can_),
             static_cast<bool>(can_.velocity_limit)),
      stillness_(can_.position_step_rad), policy_(mode_of(file.safety.policy)),
      holds_a_position_(!stopper_->plan({.mode = Mode::hold}, {}).has_value()), is_absolute_(is_absolute(resolved)),
      referenced_(is_absolute_), answered_at_(clock.now())
{
    if (policy_ == Mode::brake && !can_.brake)
        policy_ = Mode::hold;
    unseen_hold_ = hold_unseen(*stopper_);
    may_press_on_ = can_be_relieved(device());
    if (const auto plan = stopper_->plan({.mode = Mode::release}, {}))
        acknowledges_ = answers(resolved.device, *plan->all().back().message);
    stopper_ = make_driver(resolved.device);
}

Error Joint::named(Error error) const
{
    if (!error.detail.starts_with(name()))
        error.detail = error.detail.empty() ? std::string{} : fmt::format("{}: {}", name(), error.detail);
    return error;
}

void Joint::tell(Errc code, std::string says)
{
    incidents_->add({now(), name(), code, std::move(says)});
}

/// A stop ends what others were asked, who were not silent because of that; but one after another may.
void Joint::note_missing(const Error& error, TimePoint since)
{
    if (missing_since_)
        return;
    if (error.code != Errc::stopped)
        missing_since_ = cut_since_.value_or(since);
    else if (!cut_since_)
        cut_since_ = now();
    else if (is_doubtful(now() - *cut_since_))
        missing_since_ = cut_since_;
}

void Joint::failed(const Error& error, TimePoint since, const wire::Request* asked)
{
    ++failures_;
    trouble_ = error;
    note_missing(error, since);
    fresh_ = true;
    if (asked == nullptr || asked->message->info.access == wire::Access::read)
        return;
    unheard_ = true;
    const auto relief = relief_.all();
    if (std::ranges::find(relief, asked->message, &wire::Request::message) != relief.end() && !must_relieve_) {
        must_relieve_ = retries_ > 0;
        may_press_on_ = retries_ == 0; // the next stop tries again
        retries_ = std::max(0, retries_ - 1);
    }
}

// ---- commands ----

/// Each lets a load come down a little.
constexpr int most_retries = 2;

/// Whether the robot must do in steps what the device cannot do in one move.
bool Joint::can_walk(const Command& command) const
{
    if (command.mode != Mode::position)
        return false;
    return (command.velocity_rad_s && !can_.velocity_limit) || (command.duration && !can_.timed);
}

/// A share of the supply is a velocity where the device says so.
std::expected<void, Error> Joint::check_duty(const Command& command) const
{
    if (command.mode != Mode::duty || !can_.velocity_is_duty || !limits().velocity_max_rad_s ||
        !can_.velocity_max_rad_s)
        return {};
    const double velocity = std::abs(*command.duty) * *can_.velocity_max_rad_s / can_.duty_max;
    if (velocity <= *limits().velocity_max_rad_s)
        return {};
    return actuator::refuse(Errc::out_of_range, id_of(device()),
                            fmt::format("{}: duty {:g} turns it at {:.1f} deg/s, {:.1f} deg/s are allowed", name(),
                                        *command.duty, units::deg(velocity), units::deg(*limits().velocity_max_rad_s)));
}

/// Whether it takes commands.
std::expected<void, Error> Joint::check_open() const
{
    if (closed_ == nullptr)
        return {};
    return actuator::refuse(
        Errc::unsupported, id_of(device()),
        fmt::format("{}: {}{}", name(), closed_, closed_by_ ? ": " + to_sentence(*closed_by_) : ""));
}

std::expected<void, Error> Joint::set(const Command& command)
{
    if (auto open = check_open(); !open)
        return open;
    Command bare = command;
    if (can_walk(command)) {
        if (command.velocity_rad_s && command.duration)
            return actuator::refuse(Errc::bad_argument, id_of(device()),
                                    fmt::format("{}: a move has a velocity or a duration, not both", name()));
        for (const auto& value :
             {command.velocity_rad_s, command.duration ? std::optional(seconds(*command.duration)) : std::nullopt})
            if (value && !(*value > 0.0 && std::isfinite(*value)))
                return actuator::refuse(Errc::out_of_range, id_of(device()),
                                        fmt::format("{}: the velocity or duration of a move must be above 0", name()));
        bare.velocity_rad_s.reset();
        bare.duration.reset();
    }
    if (auto fine = actuator::check(mounting_.to_actuator(bare), driver_->capabilities(), id_of(device())); !fine)
        return std::unexpected(named(std::move(fine.error())));
    if (auto fine = check_duty(command); !fine)
        return fine;
    const TimePoint at = now();
    const auto admitted = guard_.admit(command, state_, at);
    if (!admitted)
        return std::unexpected(admitted.error());
    take(*admitted, at);
    return {};
}

bool Joint::same(const Command& a, const Command& b)
{
    return a.mode == b.mode && a.position_rad == b.position_rad && a.velocity_rad_s == b.velocity_rad_s &&
           a.current_a == b.current_a && a.torque_nm == b.torque_nm && a.duty == b.duty && a.duration == b.duration &&
           a.resolution_rad == b.resolution_rad;
}

void Joint::take(const Command& command, TimePoint at)
{
    commanded_at_ = at;
    if (same(command, command_))
        return;
    begins_anew_ = begins_anew_ || is_unplaced(at); // whoever looks before it goes out
    if (can_walk(command))
        guard_.catch_up(state_, at);
    const double here = guard_.reference_rad().value_or(0.0);
    command_ = command;
    fresh_ = true;
    has_heard_ = false;
    repetitions_ = 1;
    walk_.reset();
    const bool pressed = presses() || may_press_on_ || must_relieve_;
    must_relieve_ = false;
    may_press_on_ = pressed && !lets_go(command); // to be where it is already takes nothing away, nor does to press on
    relief_.clear();
    if (is_to_stand(command))
        note_whether_it_turns();
    else
        slowing_.reset();
    if (command.duration && command.mode == Mode::position) {
        deadline_ = at + *command.duration;
        mean_velocity_rad_s_ = std::abs(*command.position_rad - here) / seconds(*command.duration);
    }
    if (can_walk(command)) {
        walk_ = Walk{.to_rad = *command.position_rad,
                     .velocity_rad_s = command.velocity_rad_s.value_or(mean_velocity_rad_s_),
                     .at = at};
    }
    if (command.mode == Mode::release && !acknowledges_)
        full_at_ = at; // its word for it takes the place of repetitions
    if (command.mode == Mode::hold) {
        held_ = raw_;
        must_relieve_ = std::exchange(may_press_on_, false);
        retries_ = most_retries;
    }
}

/// Not as asked, but as the robot must.
void Joint::hold_here(TimePoint at)
{
    take({.mode = Mode::hold}, at);
    held_ = raw_;
    fresh_ = true;
}

void Joint::overrule(Error why)
{
    ++overruled_;
    trouble_ = why;
    overruled_by_ = std::move(why);
}

/// What the device was told before is forgotten, or may be.
void Joint::start_afresh(std::string why, TimePoint at)
{
    why += command_.mode == Mode::release ? "; it is set up again and stays released"
           : command_.mode == Mode::brake ? "; it is set up again and stays braked"
                                          : "; it is set up again and holds where it is";
    tell(Errc::bad_reply, why);
    silence_.reset();
    leapt_ = false;
    must_set_up_ = true;
    planned_at_ = at; // it may have come up switched on, whatever it said before
    guard_.begin(state_, at);
    if (command_.mode != Mode::release && command_.mode != Mode::brake) {
        hold_here(at);
        overrule({.code = Errc::bad_reply, .detail = std::move(why)});
    }
    fresh_ = true;
}

/// `how`: held, braked or let go.
void Joint::come_to_rest(Mode how, TimePoint at)
{
    if (how == Mode::hold)
        return hold_here(at);
    take({.mode = how}, at);
}

/// The command is over: what the policy says.
void Joint::end(TimePoint at)
{
    come_to_rest(policy() == Mode::hold ? holding(false) : policy(), at);
}

/// From the measured position, with torque.
void Joint::begin(TimePoint at)
{
    const bool may_press_on = (may_press_on_ || must_relieve_) && robot::may_press(device(), raw_, at);
    must_relieve_ = may_press_on_ = false;
    if (planned_.mode != Mode::hold)
        slowing_.reset(); // what it took before it was let go
    command_ = {.mode = Mode::release};
    is_told_ = false;
    silence_.reset();
    leapt_ = false;
    guard_.begin(state_, at);
    hold_here(at);
    must_relieve_ = must_relieve_ || may_press_on;
}

} // namespace sinew::robot
