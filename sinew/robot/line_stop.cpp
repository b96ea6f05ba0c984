#include "sinew/family/broadcast.hpp"
#include "sinew/robot/line.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <utility>

/// What a stop sends to one bus, made ready beforehand.
namespace sinew::robot {

bool Line::is_of_before_a_loss(const Joint& joint) const
{
    return bus_->losses() != seen_losses_ || (joint.raw_.position_rad && joint.raw_.position_rad.at() < back_since_);
}

/// Where it was before it was braked it is no more.
bool Line::tells_no_place(const Joint& joint, Joint::Places places, TimePoint at) const
{
    if (bus_ == nullptr) // what it takes is only predicted (load.cpp)
        return places == Joint::Places::none;
    const bool was_braked = joint.is_told_ && joint.told_ != Mode::hold;
    const bool is_before = was_braked && joint.holds_a_position_ && joint.raw_.position_rad &&
                           joint.raw_.position_rad.at() <= joint.told_at_;
    return places == Joint::Places::none || bus_->link_trouble() != nullptr || is_before ||
           (!joint.was_told_to_hold() &&
            ((joint.holds_a_position_ && is_of_before_a_loss(joint)) || joint.is_unseen(places, at)));
}

/// Until when it is right: what holds a position must be told where it is now. Nothing else changes but by the command.
TimePoint Line::collect_stop(std::vector<wire::Request>& into, Whom whom, Joint::Places places, TimePoint at) const
{
    into.clear();
    const auto is_left_alone = [whom](const Joint& joint) { return whom == Whom::owing && !joint.owes_stop_; };
    const auto is_told = [&](Mode mode) {
        return std::ranges::all_of(joints_, [&](const Joint* joint) {
            return !is_left_alone(*joint) && joint->stopping(tells_no_place(*joint, places, at)) == mode;
        });
    };
    TimePoint until = TimePoint::max();
    if (!joints_.empty())
        if (const auto all = stop_of_all(joints_.front()->family()); all && is_told(all->mode))
            into.push_back(all->request);
    for (Joint* joint : joints_) {
        if (is_left_alone(*joint))
            continue;
        const bool unseen = tells_no_place(*joint, places, at);
        if (const auto requests = joint->plan_policy(*joint->stopper_, unseen))
            for (const auto& request : requests->all())
                into.push_back(request);
        const bool is_told_once_more = whom == Whom::all && joint->was_told_to_hold();
        if (!unseen && !is_told_once_more && joint->stopping(unseen) == Mode::hold)
            until = std::min(until, joint->seen_until(places));
    }
    return until;
}

/// Whose place may be too old then is told none from the beginning: where one is too old when it is sent, none is told
/// to all.
void Line::prepare_stop(TimePoint at)
{
    if (busy_)
        return;
    using enum Joint::Places;
    const TimePoint until = collect_stop(stop_requests_, Whom::all, fresh, at);
    collect_stop(unseen_stop_requests_, Whom::all, none, at);
    bus_->set_stop(stop_requests_, until, unseen_stop_requests_);
    for (Joint* joint : joints_) {
        joint->ready_ = joint->stopping(tells_no_place(*joint, fresh, at));
        joint->ready_place_ = joint->place_to_hold();
    }
}

/// Where nobody has asked for longer than usual, its joints may have lost their supply, and have been moved. Whoever
/// asks seldom does not forget every time: at each new place a load comes down a little.
void Line::forget_where_it_held(TimePoint now)
{
    if (busy_ || absorbed_at_ == TimePoint{})
        return;
    const Duration gap = now - absorbed_at_;
    const Duration usual = std::exchange(usual_gap_, std::max(gap, usual_gap_ / 2));
    if (gap > std::clamp<Duration>(2 * usual, doubtful_silence, longest_trust))
        for (Joint* joint : joints_)
            joint->is_held_ = false;
}

/// It has gone out.
void Line::note_the_stop(TimePoint now)
{
    for (Joint* joint : joints_)
        joint->begin_telling(bus_->said_later() ? joint->stopping(true) : joint->ready_, joint->ready_place_, now);
}

Line::BlindStop Line::blind_stop(Whom whom, TimePoint now)
{
    using enum Joint::Places;
    const TimePoint until = collect_stop(blind_stop_requests_, whom, latest, now);
    if (whom == Whom::all)
        return {blind_stop_requests_, until, unseen_stop_requests_};
    collect_stop(blind_unseen_requests_, whom, none, now);
    return {blind_stop_requests_, until, blind_unseen_requests_};
}

void Line::close_stop()
{
    if (!std::exchange(owes_stop_, false))
        return bus_->clear_stop();
    if (!std::ranges::all_of(bus_->stop_results(), &bus::Result::good))
        for (Joint* joint : joints_)
            joint->owes_stop_ = true;
    end_stop();
}

/// What has stopped is not told again where it was then.
void Line::end_stop()
{
    bus_->set_stop({});
    bus_->clear_stop();
}

} // namespace sinew::robot
