#include "sinew/base/seconds.hpp"
#include "sinew/robot/drive.hpp"
#include "sinew/robot/joint.hpp"
#include "sinew/robot/pressing.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

/// What goes out to a joint in a cycle and in a stop.
namespace sinew::robot {
namespace {

/// The loop may have been late; what it was late by is not walked at once.
constexpr Duration longest_step = std::chrono::milliseconds{50};

} // namespace

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
    } else if (out.mode == Mode::position && holds_a_position_) {
        out.position_rad = guard_.nearest_step_rad(*out.position_rad, at);
    }
    if (out.mode == Mode::position)
        out.position_rad = guard_.nearest_allowed_rad(*out.position_rad, state_);
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

/// By its own word since it was told. A Nuri writes what it is told of that into its flash.
bool Joint::has_let_go() const
{
    return planned_.mode == Mode::release && raw_.says_off() && raw_.enabled.at() > planned_at_;
}

bool Joint::must_send(const Command& command, TimePoint at) const
{
    if (command.mode == Mode::release && !acknowledges_ && has_let_go())
        return false;
    if (fresh_ || repetitions_ > 0)
        return true;
    if (command.duration)
        return false;
    return acknowledges_ || !same(command, planned_) || at - planned_at_ >= repetition;
}

/// A device that does not answer may have lost its supply, and its shaft may be anywhere: what it was told last would
/// be a leap when it hears again. What cannot make it leap goes out all the same, for it may hear.
bool Joint::may_send(TimePoint at) const
{
    const Mode mode = command_.mode;
    if (lets_go(command_) || (mode == Mode::hold && !holds_a_position_))
        return true;
    const bool is_leap = holds_a_position_ && (mode == Mode::position || mode == Mode::hold);
    return !silence_ && !(is_leap ? missing_since_ || is_unplaced(at) : is_silent());
}

/// Instead of a command that may not be sent. What drives without end and is to do something else is stopped, wherever
/// it is: it may hear. So is what is to turn no more: of a ramp that is told again and again (Nuri) there is no end.
std::expected<wire::Requests, Error> Joint::plan_look(double resolution_rad)
{
    const bool is_to_end = is_endless(planned_.mode) && !same(mounting_.to_actuator(command_), planned_);
    const bool is_to_turn_no_more = command_.mode == Mode::velocity && sense_of(command_) == 0.0;
    if (is_to_end || is_to_turn_no_more)
        return driver_->plan_cycle({.mode = unseen_hold_}, raw_);
    return driver_->plan_read(Depth::motion, resolution_rad);
}

void Joint::went_out(const Command& own, TimePoint at)
{
    planned_ = own;
    planned_at_ = at;
    is_held_ = own.mode == Mode::hold;
}

/// Then it presses no more on what it did press on.
void Joint::see_whether_it_turns_freely(TimePoint at)
{
    if (may_press_on_ && !presses() && robot::may_meet_something(device(), planned_, raw_, at))
        may_press_on_ = false;
}

/// What it was told while nobody had looked for a while, it was told by where it had been.
void Joint::begin_where_it_is(TimePoint at)
{
    if (!std::exchange(begins_anew_, false))
        return;
    if (command_.mode == Mode::hold && planned_.mode != Mode::hold)
        held_ = raw_;
    if (command_.mode == Mode::position)
        guard_.catch_up(state_, at);
}

std::expected<wire::Requests, Error> Joint::plan(TimePoint at, double resolution_rad)
{
    relief_.clear();
    see_whether_it_turns_freely(at);
    if (command_.mode == Mode::hold && has_met_something())
        must_relieve_ = true;
    if (!may_send(at)) {
        begins_anew_ = begins_anew_ || is_unplaced(at);
        return plan_look(resolution_rad);
    }
    begin_where_it_is(at);
    const Command command = next(at);
    const Command own = mounting_.to_actuator(command);
    const bool sends = must_send(own, at);
    const bool is_position = command.mode == Mode::position;
    const auto& here = command.mode == Mode::hold ? held_ : raw_;
    const bool relieves = sends && must_relieve_ && command.mode == Mode::hold;
    auto requests = relieves ? plan_hold_anew(*driver_, here, true)
                    : sends  ? driver_->plan_cycle(own, here)
                             : driver_->plan_read(Depth::motion, resolution_rad);
    if (!requests)
        return requests;
    if (sends) {
        if (relieves)
            relief_ = *requests;
        must_relieve_ = false;
        if (!fresh_)
            repetitions_ = std::max(0, repetitions_ - 1);
        fresh_ = false;
        if (acknowledges_)
            repetitions_ = 0;
        went_out(own, at);
    } else {
        fresh_ = false; // it has let go already
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

/// A hand moves what was let go as soon as nobody looks, and what was sent elsewhere is on its way.
bool Joint::is_to_stay() const
{
    const bool is_there = planned_.mode == Mode::position && planned_.position_rad && raw_.position_rad &&
                          std::abs(*planned_.position_rad - *raw_.position_rad) <= 2 * giving_way_rad;
    return !lets_go(command_) && (planned_.mode == Mode::hold || is_there);
}

/// Later nobody has looked for a while: the program did something else, and so may a hand have.
TimePoint Joint::seen_until(Places places) const
{
    if (places == Places::none || (holds_a_position_ && !raw_.position_rad))
        return TimePoint::min();
    if (!holds_a_position_)
        return TimePoint::max();
    Duration lasting =
        (is_to_stay() ? std::min<Duration>(usual_silence(), longest_trust) : doubtful_silence) + 2 * exchange_;
    const double speed_rad_s = std::abs(guard_.velocity_rad_s()) * mounting_.ratio;
    if (places == Places::fresh && speed_rad_s * seconds(lasting) > giving_way_rad)
        lasting = from_seconds(giving_way_rad / speed_rad_s);
    return raw_.position_rad.at() + lasting;
}

bool Joint::holds_there() const
{
    constexpr double at_all_its_torque = 2 * giving_way_rad;
    return is_held_ && !silence_ && !raw_.says_off() && held_.position_rad && raw_.position_rad &&
           std::abs(*held_.position_rad - *raw_.position_rad) <= at_all_its_torque;
}

void Joint::begin_telling(Mode mode, const State& place, TimePoint at)
{
    unheard_ = has_let_go_of_it_ = false;
    is_told_ = true;
    told_ = mode;
    told_at_ = at;
    is_held_ = mode == Mode::hold;
    if (is_held_)
        held_ = place;
}

Mode Joint::stopping(bool unseen) const
{
    return policy() == Mode::hold ? holding(unseen) : policy();
}

std::expected<wire::Requests, Error> Joint::plan_policy(actuator::Driver& driver, bool unseen) const
{
    return driver.plan({.mode = stopping(unseen)}, place_to_hold());
}

void Joint::note_whether_it_turns()
{
    if (!robot::may_meet_something(device(), planned_, raw_, now()))
        return;
    slowing_ = Slowing{raw_.current_a};
    stillness_.begin();
}

bool Joint::has_met_something()
{
    if (!slowing_ || !stillness_.is_at_rest())
        return false;
    const auto before_a = std::exchange(slowing_, std::nullopt)->current_a;
    return robot::may_press(device(), raw_, now()) && robot::has_met_something(before_a, raw_.current_a);
}

bool Joint::presses() const
{
    return robot::presses(device(), planned_, raw_, now());
}

} // namespace sinew::robot
