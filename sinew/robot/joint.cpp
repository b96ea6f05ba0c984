#include "sinew/robot/joint.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/robot/drive.hpp"
#include "sinew/robot/hold_unseen.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace sinew::robot {
namespace {

/// The loop may have been late; what it was late by is not walked at once.
constexpr Duration longest_step = std::chrono::milliseconds{50};
/// What nobody acknowledges is said again after so long.
constexpr Duration repetition = std::chrono::milliseconds{250};

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

bool same(const Command& a, const Command& b)
{
    return a.mode == b.mode && a.position_rad == b.position_rad && a.velocity_rad_s == b.velocity_rad_s &&
           a.current_a == b.current_a && a.torque_nm == b.torque_nm && a.duty == b.duty && a.duration == b.duration &&
           a.resolution_rad == b.resolution_rad;
}

} // namespace

Joint::Joint(const ResolvedJoint& resolved, const config::RobotFile& file, const link::Clock& clock,
             Incidents& incidents)
    : resolved_(&resolved), clock_(&clock), incidents_(&incidents), mounting_(Mounting::of(*resolved.joint)),
      driver_(make_driver(resolved.device)), stopper_(make_driver(resolved.device)),
      can_(mounting_.to_joint(driver_->capabilities())),
      guard_(resolved.joint->name, id_of(resolved.device), rules_of(*resolved.joint, file.safety, can_),
             static_cast<bool>(can_.velocity_limit)),
      policy_(mode_of(file.safety.policy)), holds_a_position_(!stopper_->plan({.mode = Mode::hold}, {}).has_value()),
      referenced_(is_absolute(resolved)), answered_at_(clock.now())
{
    if (policy_ == Mode::brake && !can_.brake)
        policy_ = Mode::hold;
    unseen_hold_ = hold_unseen(*stopper_);
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

void Joint::failed(const Error& error, TimePoint since)
{
    ++failures_;
    trouble_ = error;
    if (!missing_since_)
        missing_since_ = since;
    fresh_ = true;
}

// ---- commands ----

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

void Joint::take(const Command& command, TimePoint at)
{
    commanded_at_ = at;
    if (same(command, command_))
        return;
    const double here = guard_.reference_rad().value_or(0.0);
    command_ = command;
    fresh_ = true;
    repetitions_ = 1;
    walk_.reset();
    if (command.duration && command.mode == Mode::position) {
        deadline_ = at + *command.duration;
        mean_velocity_rad_s_ = std::abs(*command.position_rad - here) / seconds(*command.duration);
    }
    if (can_walk(command)) {
        walk_ = Walk{.to_rad = *command.position_rad,
                     .velocity_rad_s = command.velocity_rad_s.value_or(mean_velocity_rad_s_),
                     .at = at};
    }
    if (command.mode == Mode::hold)
        held_ = raw_;
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
    tell(Errc::bad_reply, why);
    silence_.reset();
    must_set_up_ = true;
    referenced_ = referenced_ && family().name != "nuri";
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
    come_to_rest(stopping(false), at);
}

/// From the measured position, with torque.
void Joint::begin(TimePoint at)
{
    command_ = {.mode = Mode::release};
    silence_.reset();
    guard_.begin(state_, at);
    hold_here(at);
}

/// What is to be sent now, in joint units.
Command Joint::next(TimePoint at)
{
    Command out = command_;
    if (walk_) {
        const double from = guard_.reference_rad().value_or(walk_->to_rad);
        const double step = walk_->velocity_rad_s * seconds(std::min<Duration>(at - walk_->at, longest_step));
        walk_->at = at;
        const double way = walk_->to_rad - from;
        out.position_rad = guard_.nearest_lead_rad(from + std::clamp(way, -step, step), at);
        out.velocity_rad_s.reset();
        out.duration.reset();
    } else if (command_.mode == Mode::position && command_.duration) {
        rest_of_move(out, at);
    }
    return out;
}

/// A move with a duration that is said again must not become a faster one.
void Joint::rest_of_move(Command& command, TimePoint at) const
{
    if (can_.timing == actuator::Timing::by_speed && mean_velocity_rad_s_ > 0.0) {
        command.duration.reset();
        command.velocity_rad_s = mean_velocity_rad_s_;
        return;
    }
    const double way = std::abs(*command.position_rad - state_.position_rad.value_or(*command.position_rad));
    const Duration least = mean_velocity_rad_s_ > 0.0 ? from_seconds(way / mean_velocity_rad_s_) : Duration{};
    command.duration = std::max<Duration>({deadline_ - at, least, std::chrono::milliseconds{1}});
}

bool Joint::must_send(const Command& command, TimePoint at) const
{
    if (fresh_ || repetitions_ > 0)
        return true;
    if (command.duration)
        return false;
    return acknowledges_ || !same(command, planned_) || at - planned_at_ >= repetition;
}

/// A device that does not answer may have lost its supply, and its shaft may be anywhere: what it was told last would
/// be a leap when it hears again. What cannot make it leap goes out all the same, for it may hear.
bool Joint::may_send() const
{
    const Mode mode = command_.mode;
    if (lets_go(command_) || (mode == Mode::hold && !holds_a_position_))
        return true;
    const bool is_leap = holds_a_position_ && (mode == Mode::position || mode == Mode::hold);
    return !silence_ && !(is_leap ? missing_since_.has_value() : is_silent());
}

/// Instead of a command that may not be sent. What drives without end and is to do something else is stopped, wherever
/// it is: it may hear. So is what is to turn no more: of a ramp that is told again and again (Nuri) there is no end.
std::expected<wire::Requests, Error> Joint::plan_look(double resolution_rad)
{
    const bool is_to_end = is_endless(planned_.mode) && !same(mounting_.to_actuator(command_), planned_);
    const bool is_to_stand = command_.mode == Mode::velocity && sense_of(command_) == 0.0;
    if (is_to_end || is_to_stand)
        return driver_->plan_cycle({.mode = unseen_hold_}, raw_);
    return driver_->plan_read(Depth::motion, resolution_rad);
}

void Joint::went_out(const Command& own, TimePoint at)
{
    planned_ = own;
    planned_at_ = at;
}

std::expected<wire::Requests, Error> Joint::plan(TimePoint at, double resolution_rad)
{
    if (!may_send())
        return plan_look(resolution_rad);
    const Command command = next(at);
    const Command own = mounting_.to_actuator(command);
    const bool sends = must_send(own, at);
    const bool is_position = command.mode == Mode::position;
    const auto& here = command.mode == Mode::hold ? held_ : raw_;
    auto requests = sends ? driver_->plan_cycle(own, here) : driver_->plan_read(Depth::motion, resolution_rad);
    if (!requests)
        return requests;
    if (sends) {
        if (!fresh_)
            repetitions_ = std::max(0, repetitions_ - 1);
        fresh_ = false;
        if (acknowledges_)
            repetitions_ = 0;
        went_out(own, at);
    }
    // Who holds without being told where holds where he comes to rest.
    const bool holds_there = command.mode == Mode::hold && holds_a_position_;
    const auto& place = holds_there ? held_.position_rad : raw_.position_rad;
    if (is_position)
        guard_.sent(*command.position_rad, at);
    else if (place && holds_there)
        guard_.sent(mounting_.to_joint(*place), at);
    else if (place)
        guard_.follow(mounting_.to_joint(*place), at);
    return requests;
}

Mode Joint::policy() const
{
    // A joint that was let go is not seized by a stop.
    return command_.mode == Mode::release ? Mode::release : policy_;
}

Mode Joint::holding(bool unseen) const
{
    // A device that is too hot for a position lets its shaft coast (SAM, L714), and would leap to it as soon as it has
    // cooled.
    const bool is_hot = raw_.faults && raw_.faults->has(actuator::Fault::over_temperature);
    return unseen || is_hot || is_silent() ? unseen_hold_ : Mode::hold;
}

Mode Joint::stopping(bool unseen) const
{
    return policy() == Mode::hold ? holding(unseen) : policy();
}

std::expected<wire::Requests, Error> Joint::plan_policy(actuator::Driver& driver, bool unseen) const
{
    return driver.plan({.mode = stopping(unseen)}, raw_);
}

} // namespace sinew::robot
