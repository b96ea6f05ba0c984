#include "sinew/robot/core.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/pressing.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

/// Stopping: the ready-made frames first, then asking who obeyed.
namespace sinew::robot {
namespace {

constexpr int most_repetitions = 3; ///< of what was not confirmed
constexpr int most_silences = 2;    ///< so often one is told that answers nothing: each waits for a time-out
constexpr int fewest_looks = 10;    ///< at the others, whatever time those took
/// What nobody acknowledged may not have been heard, though where it is is answered. Not at every look: a ramp to rest
/// that is told again begins anew, and what is refused is refused again.
constexpr Duration until_it_is_told_again = std::chrono::milliseconds{200};
/// Noise that takes the stop away and all answers ends some time; what turns must hear it then.
constexpr Duration patience_with_silence = std::chrono::milliseconds{500};
constexpr Duration between_looks = std::chrono::milliseconds{20};

} // namespace

/// The frames of all buses at the next frame boundary. A bus whose link is lost keeps them until it is back.
void Core::send_stop()
{
    for (auto& line : lines)
        line->prepare_stop(clock->now());
    for (bus::Bus* bus : buses)
        bus->request_stop();
    drive();
    const TimePoint now = clock->now();
    for (auto& line : lines) {
        if (line->busy())
            line->absorb(now);
        if (line->bus().link_trouble() == nullptr) {
            line->note_the_stop(now);
            line->end_stop();
        } else {
            line->prepare_stop(now); // for when it is back
        }
        line->owe_stop(line->bus().link_trouble() != nullptr);
    }
}

/// One look at all joints that have not confirmed yet.
struct Core::Look {
    TimePoint begun{};
    int number = 0;
    bool commands = false;          ///< all of them are told again what they have to do
    bool is_one_on_its_way = false; ///< who answers
};

Stopped& Core::outcome_of(const Joint& joint, std::vector<Stopped>& outcomes) const
{
    return outcomes[static_cast<std::size_t>(&joint - joints.data())];
}

bool Core::is_worth_asking(const Joint& joint, const Stopped& outcome)
{
    return outcome.outcome != Stopped::Outcome::confirmed && !joint.is_given_up_ &&
           (joint.silences_ < most_silences || joint.silent_for_ < patience_with_silence);
}

/// Each time-out of one that does not answer keeps the others waiting: he is not asked as long as another one, who
/// answers, is on his way to rest.
bool Core::is_asked(const Joint& joint, const Stopped& outcome, const Look& look)
{
    return is_worth_asking(joint, outcome) && (joint.silences_ < most_silences || !look.is_one_on_its_way);
}

/// Told again where that may be news to him. Nobody is asked for more than where he is before he has answered, nor for
/// that where his answer to the command says that he is there.
void Core::ask(Line& line, Joint& joint, Stopped& outcome, const Look& look)
{
    // A reading may say that it cannot do what it was told.
    const bool unseen = line.tells_no_place(joint, Joint::Places::fresh, clock->now());
    const Mode now = joint.stopping(unseen);
    const bool is_new = std::exchange(outcome.did, now) != now;
    const bool has_not_heard = joint.unheard_ || joint.is_limp(now);
    const bool is_time = look.begun - joint.told_at_ >= until_it_is_told_again || joint.is_heard_again_;
    const bool tells = look.commands || is_new || (has_not_heard && look.number < most_repetitions) ||
                       (is_time && (has_not_heard || !joint.acknowledges_));
    if (tells)
        if (const auto plan = joint.plan_policy(*joint.driver_, unseen)) {
            joint.begin_telling(now, joint.place_to_hold(), look.begun);
            line.add(joint, plan->all());
        }
    const bool may_be_gone = look.number == 0 || joint.missing_since_;
    if (!(may_be_gone && tells && joint.acknowledges_))
        (void)line.plan_read(joint, may_be_gone ? Depth::motion : Depth::full);
}

/// By what it has answered since then.
bool Core::has_obeyed(const Joint& joint, Mode told, TimePoint since)
{
    const bool says_off = joint.raw_.says_off() && joint.raw_.enabled.at() >= since;
    const bool may_say_off = joint.can_.measures_enabled;
    const bool has_obeyed =
        told == Mode::release ? says_off || (!may_say_off && joint.acknowledges_) : joint.stillness_.is_at_rest();
    return has_obeyed && !joint.unheard_ && !joint.is_limp(told);
}

/// What came of that.
void Core::hear(Joint& joint, Stopped& outcome, const Look& look)
{
    const bool answered = joint.answered_at_ >= look.begun;
    // A link that is back sends its stop first, which ends what it was asked: that is no silence.
    const bool is_cut_short = !answered && joint.trouble_ && joint.trouble_->code == Errc::stopped;
    joint.is_heard_again_ = answered && joint.silences_ > 0;
    if (answered) {
        joint.silences_ = 0;
        joint.silent_for_ = {};
    } else if (!is_cut_short) {
        ++joint.silences_;
        joint.silent_for_ += clock->now() - look.begun + between_looks;
    }
    if (!answered) {
        outcome.why = joint.trouble_.value_or(Error{.code = Errc::timeout});
        return;
    }
    const bool done = has_obeyed(joint, outcome.did, look.begun);
    outcome.outcome = done ? Stopped::Outcome::confirmed : Stopped::Outcome::sent;
}

/// One look. Whether another one is worth it.
bool Core::ask_again(std::vector<Stopped>& outcomes, int number, bool commands)
{
    Look look{.begun = clock->now(), .number = number, .commands = commands};
    look.is_one_on_its_way = std::ranges::any_of(joints, [&](const Joint& joint) {
        const Stopped& one = outcome_of(joint, outcomes);
        return one.outcome == Stopped::Outcome::sent && joint.silences_ < most_silences && joint.can_confirm(one.did);
    });
    std::vector<Joint*> asked;
    for (auto& line : lines) {
        line->clear();
        for (Joint* joint : line->joints())
            if (auto& outcome = outcome_of(*joint, outcomes); is_asked(*joint, outcome, look)) {
                asked.push_back(joint);
                ask(*line, *joint, outcome, look);
            }
    }
    exchange_lines();
    for (Joint* joint : asked)
        hear(*joint, outcome_of(*joint, outcomes), look);
    return std::ranges::any_of(joints,
                               [&](const Joint& joint) { return is_worth_asking(joint, outcome_of(joint, outcomes)); });
}

/// One that is asked for meanwhile ends every exchange until it is carried out.
bool Core::heed_another_stop()
{
    const bool is_asked_for = stop_asked_.exchange(false);
    if (is_asked_for) {
        for (bus::Bus* bus : buses)
            bus->clear_stop(); // it ended what ran, and had nothing to send
        send_stop();
    }
    return is_asked_for;
}

/// Who was braked, for it was not known where he was, falls under his load until he is told where to hold: each is
/// asked that and told at once, one after another. Whether anybody was.
bool Core::hold_what_was_braked(std::vector<Stopped>& outcomes)
{
    const auto is_braked = [&](Line& line, const Joint& joint) {
        return joint.is_told_ && joint.told_ != Mode::hold && joint.stopping(false) == Mode::hold &&
               line.bus().link_trouble() == nullptr && joint.silences_ == 0 && !joint.missing_since_;
    };
    const auto exchange_with = [&](Line& one, Joint& joint, const std::expected<wire::Requests, Error>& plan) {
        for (auto& line : lines)
            line->clear();
        if (plan)
            one.add(joint, plan->all());
        exchange_lines();
    };
    bool any = false;
    for (auto& line : lines)
        for (Joint* joint : line->joints())
            for (int times = 0; times < most_repetitions && is_braked(*line, *joint) && !stop_asked_.load(); ++times) {
                const TimePoint begun = clock->now();
                exchange_with(*line, *joint, joint->driver_->plan_read(Depth::motion));
                if (!joint->raw_.position_rad || joint->raw_.position_rad.at() < begun)
                    continue; // it is not believed yet
                const auto plan = joint->plan_policy(*joint->driver_, false);
                joint->begin_telling(Mode::hold, joint->place_to_hold(), clock->now());
                outcome_of(*joint, outcomes).did = Mode::hold;
                outcome_of(*joint, outcomes).outcome = Stopped::Outcome::sent;
                joint->stillness_.begin();
                exchange_with(*line, *joint, plan);
                any = true;
            }
    return any;
}

void Core::verify(std::vector<Stopped>& outcomes, TimePoint end)
{
    for (int look = 0;; ++look) {
        if (heed_another_stop() && clock->now() < end)
            look = 0;
        if (look == 0)
            hold_what_was_braked(outcomes); // before it waits for who does not answer
        const bool all_answered =
            std::ranges::none_of(outcomes, [](const Stopped& one) { return one.outcome == Stopped::Outcome::failed; });
        const bool command = look == 0 || (look < most_repetitions && !all_answered);
        bool goes_on = ask_again(outcomes, look, command);
        goes_on = hold_what_was_braked(outcomes) || goes_on;
        if (!goes_on || (look >= fewest_looks && clock->now() >= end))
            return;
        const TimePoint until = clock->now() + between_looks;
        while (clock->now() < until)
            clock->wait({}, until);
        show_life();
    }
}

/// Each lets go of what it presses on, and holds. Who does not acknowledge every frame of that is told again; those are
/// returned who never do.
std::vector<Joint*> Core::hold_anew(std::vector<Joint*> left)
{
    for (int time = 0; time < most_repetitions && !left.empty(); ++time) {
        heed_another_stop();
        std::vector<std::uint64_t> failures;
        for (const Joint* joint : left)
            failures.push_back(joint->failures_);
        for (auto& line : lines) {
            line->clear();
            for (Joint* joint : line->joints())
                if (std::ranges::find(left, joint) != left.end())
                    if (const auto plan = plan_hold_anew(*joint->driver_, joint->raw_)) {
                        joint->unheard_ = false;
                        line->add(*joint, plan->all());
                    }
        }
        exchange_lines();
        std::vector<Joint*> again;
        for (std::size_t i = 0; i < left.size(); ++i)
            if (left[i]->failures_ != failures[i])
                again.push_back(left[i]);
        left = std::move(again);
    }
    return left;
}

/// Joints that hold and may press on something. One of which that is not known to have been heard is not said to hold,
/// and the next stop tries again.
void Core::relieve(std::vector<Stopped>& outcomes, TimePoint end)
{
    std::vector<Joint*> pressing;
    for (Joint& joint : joints) {
        const Stopped& outcome = outcome_of(joint, outcomes);
        const bool was_due = std::exchange(joint.must_relieve_, false), has_met = joint.has_met_something();
        joint.may_press_on_ = joint.may_press_on_ || was_due || has_met;
        joint.is_given_up_ = outcome.outcome == Stopped::Outcome::failed; // its time-outs are not waited for again
        if (joint.may_press_on_ && outcome.outcome == Stopped::Outcome::confirmed && outcome.did == Mode::hold)
            pressing.push_back(&joint);
    }
    if (pressing.empty())
        return;
    const auto left = hold_anew(pressing);
    for (Joint* joint : pressing) {
        joint->may_press_on_ = std::ranges::find(left, joint) != left.end();
        outcome_of(*joint, outcomes).outcome = Stopped::Outcome::sent;
        joint->stillness_.begin();
    }
    verify(outcomes, std::max(end, clock->now() + rest_after_relief));
    for (const Joint* joint : left) {
        outcome_of(*joint, outcomes).outcome = Stopped::Outcome::failed;
        outcome_of(*joint, outcomes).why = joint->trouble_.value_or(Error{.code = Errc::timeout});
    }
}

/// Who could have said that he obeyed, and has not, has not for all that is known.
void Core::conclude(std::vector<Stopped>& outcomes)
{
    for (Joint& joint : joints) {
        Stopped& one = outcome_of(joint, outcomes);
        if (one.outcome != Stopped::Outcome::sent || !joint.can_confirm(one.did))
            continue;
        one.outcome = Stopped::Outcome::failed;
        if (joint.silences_ > 0)
            continue;
        const std::string_view but = joint.is_limp(one.did)     ? "says that its torque is off"
                                     : joint.unheard_           ? "has not acknowledged that"
                                     : one.did == Mode::release ? "has not said that its torque is off"
                                                                : "was not seen to stand still";
        one.why = {.code = Errc::timeout,
                   .detail = fmt::format("{} was told to {} and {}", joint.name(), actuator::to_word(one.did), but)};
    }
}

/// Who has not confirmed his stop may hear it now.
void Core::plan_owed_stops(bool at_once)
{
    const TimePoint now = clock->now();
    for (auto& line : lines)
        for (Joint* joint : line->joints()) {
            const bool is_lost = line->bus().link_trouble() != nullptr;
            const bool unseen = joint->is_unseen(is_lost ? Joint::Places::none : Joint::Places::latest, now);
            const Mode mode = joint->stopping(unseen);
            const bool is_news = at_once || joint->told_ != mode;
            if (!joint->owes_stop_ || (!is_news && now - joint->told_at_ < until_it_is_told_again))
                continue;
            if (unseen && !is_lost && joint->was_told_to_hold())
                continue; // it took long to look at all the others
            // Once it stands: what turns is only told to hold. An `enable` lets go of all later.
            const bool lets_go = !is_news && joint->may_press_on_ && mode == Mode::hold &&
                                 joint->stillness_.is_at_rest() && joint->lettings_go_ < most_repetitions;
            const auto plan =
                lets_go ? plan_hold_anew(*joint->driver_, joint->raw_) : joint->plan_policy(*joint->driver_, unseen);
            if (plan) {
                joint->begin_telling(mode, joint->place_to_hold(), now);
                joint->has_let_go_of_it_ = lets_go;
                joint->lettings_go_ += lets_go ? 1 : 0;
                line->add(*joint, plan->all());
            }
        }
}

void Core::hear_of_owed_stops(TimePoint begun)
{
    for (Joint& joint : joints) {
        const Mode mode = joint.stopping(joint.is_unseen(Joint::Places::latest, clock->now()));
        if (!joint.owes_stop_ || joint.answered_at_ < begun || joint.told_ != mode ||
            !has_obeyed(joint, joint.told_, begun))
            continue;
        if (joint.has_let_go_of_it_)
            joint.may_press_on_ = false;
        joint.owes_stop_ = mode == Mode::hold && joint.may_press_on_;
    }
}

/// To hold, each must be told where he is now.
void Core::tell_owed_stops()
{
    if (std::ranges::none_of(joints, &Joint::owes_stop_))
        return;
    for (auto& line : lines)
        line->plan_first_look(clock->now());
    exchange_lines();
    for (auto& line : lines)
        line->clear();
    const TimePoint begun = clock->now();
    plan_owed_stops(false);
    for (auto& line : lines)
        for (Joint* joint : line->joints())
            if (joint->owes_stop_)
                (void)line->plan_read(*joint, Depth::full);
    exchange_lines();
    hear_of_owed_stops(begun);
}

std::vector<Stopped> Core::stop(const std::string& why)
{
    const bool was_enabled = enabled;
    enabled = false;
    std::vector<Stopped> outcomes;
    for (auto& line : lines)
        line->forget_where_it_held(clock->now());
    for (Joint& joint : joints) {
        joint.may_press_on_ = joint.may_press_on_ || joint.presses();
        joint.note_whether_it_turns();
        joint.silences_ = joint.lettings_go_ = 0;
        joint.silent_for_ = {};
        joint.is_told_ = joint.was_told_to_hold(); // by the stop before: where it is looked at seldom it holds as well
        joint.is_given_up_ = joint.is_heard_again_ = false;
        const bool unseen = joint.is_unseen(Joint::Places::fresh, clock->now());
        outcomes.push_back({.joint = joint.name(), .did = joint.stopping(unseen)});
        joint.closed_ = "the robot is stopped; enable it again";
        joint.closed_by_.reset();
        joint.walk_.reset();
        joint.stillness_.begin();
    }
    if (!fault && was_enabled && !why.empty())
        incidents.add({clock->now(), {}, Errc::stopped, "the robot was stopped: " + why});
    stop_asked_.store(false);
    send_stop();
    is_stopping_ = true;
    show_life();
    const TimePoint end = clock->now() + longest_rest;
    for (Joint& joint : joints) {
        joint.relief_.clear(); // what was under way is over
        joint.guard_.begin(joint.state_, clock->now());
    }
    verify(outcomes, end);
    relieve(outcomes, end);
    conclude(outcomes);
    tell_the_guardian_of_a_stop(outcomes);
    for (Joint& joint : joints) {
        joint.command_ = {.mode = joint.policy()};
        joint.planned_ = {.mode = joint.is_told_ ? joint.told_ : joint.policy()};
        joint.owes_stop_ = outcome_of(joint, outcomes).outcome == Stopped::Outcome::failed;
    }
    is_stopping_ = false;
    for (auto& line : lines)
        tell_the_guardian(*line);
    rest();
    return outcomes;
}

} // namespace sinew::robot
