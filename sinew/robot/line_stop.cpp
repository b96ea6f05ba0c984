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
bool Line::is_unseen(const Joint& joint, Joint::Places places, TimePoint at) const
{
    const bool was_braked = joint.is_told_ && joint.told_ != Mode::hold;
    const bool is_before = was_braked && joint.holds_a_position_ && joint.raw_.position_rad &&
                           joint.raw_.position_rad.at() <= joint.told_at_;
    return places == Joint::Places::none || bus_->link_trouble() != nullptr || is_before ||
           (!joint.was_told_to_hold() &&
            ((joint.holds_a_position_ && is_of_before_a_loss(joint)) || joint.is_unseen(places, at)));
}

/// Until when it is right: what holds a position must be told where it is now. Nothing else changes but by the command.
TimePoint Line::collect_stop(std::vector<wire::Request>& into, Joint::Places places, TimePoint at) const
{
    into.clear();
    const auto is_told = [&](Mode mode) {
        return std::ranges::all_of(
            joints_, [&](const Joint* joint) { return joint->stopping(is_unseen(*joint, places, at)) == mode; });
    };
    TimePoint until = TimePoint::max();
    if (!joints_.empty())
        if (const auto all = stop_of_all(joints_.front()->family()); all && is_told(all->mode))
            into.push_back(all->request);
    for (Joint* joint : joints_) {
        const bool unseen = is_unseen(*joint, places, at);
        if (const auto requests = joint->plan_policy(*joint->stopper_, unseen))
            for (const auto& request : requests->all())
                into.push_back(request);
        if (!unseen && !joint->was_told_to_hold() && joint->stopping(unseen) == Mode::hold)
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
    const TimePoint until = collect_stop(stop_requests_, fresh, at);
    collect_stop(unseen_stop_requests_, none, at);
    bus_->set_stop(stop_requests_, until, unseen_stop_requests_);
    for (Joint* joint : joints_) {
        joint->ready_ = joint->stopping(is_unseen(*joint, fresh, at));
        joint->ready_place_ = joint->place_to_hold();
    }
}

/// Since nobody has asked, its joints may have lost their supply, and have been moved.
void Line::forget_where_it_held(TimePoint now)
{
    if (!busy_ && now - absorbed_at_ > doubtful_silence)
        for (Joint* joint : joints_)
            joint->is_held_ = false;
}

/// It has gone out.
void Line::note_the_stop(TimePoint now)
{
    for (Joint* joint : joints_)
        joint->begin_telling(bus_->said_later() ? joint->stopping(true) : joint->ready_, joint->ready_place_, now);
}

Line::BlindStop Line::blind_stop(TimePoint now)
{
    const TimePoint until = collect_stop(blind_stop_requests_, Joint::Places::latest, now);
    return {blind_stop_requests_, until};
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
