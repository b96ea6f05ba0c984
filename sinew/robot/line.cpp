#include "sinew/robot/line.hpp"

#include "sinew/base/seconds.hpp"
#include "sinew/family/rmd/group.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace sinew::robot {
namespace {

constexpr Duration between_full_readings = std::chrono::milliseconds{500};
constexpr Duration between_reset_checks = std::chrono::seconds{1};
constexpr std::size_t most_a_joint = 3 * wire::Requests::capacity;
constexpr int last_of_group = 4;

/// Each member of a group answers for itself.
auto find_reply_of(const Joint& joint, std::span<const wire::Frame> replies)
{
    return std::ranges::find(replies, std::get<rmd::Spec>(joint.device()).reply_identifier(), &wire::Frame::can_id);
}

} // namespace

void Line::set_joints(std::vector<Joint*> joints)
{
    joints_ = std::move(joints);
    const std::size_t most = joints_.size() * most_a_joint + 1;
    requests_.resize(most);
    results_.resize(most);
    owners_.resize(most);
    for (auto* all : {&stop_requests_, &unseen_stop_requests_, &blind_stop_requests_, &blind_unseen_requests_})
        all->reserve(joints_.size() * wire::Requests::capacity + 1);
    for (Joint* joint : joints_)
        if (dynamic_cast<rmd::Driver*>(joint->driver_.get()) != nullptr && id_of(joint->device()) <= last_of_group)
            group_.push_back(joint);
}

void Line::add(Joint& joint, std::span<const wire::Request> requests)
{
    for (const auto& request : requests) {
        if (size_ == requests_.size())
            return;
        requests_[size_] = request;
        owners_[size_++] = &joint;
    }
}

std::expected<void, Error> Line::plan_read(Joint& joint, Depth depth)
{
    const auto requests = joint.driver_->plan_read(depth);
    if (!requests)
        return std::unexpected(joint.named(requests.error()));
    add(joint, requests->all());
    return {};
}

/// Whether there is nothing against going on.
bool Line::obey(Joint& joint, const Finding& finding, TimePoint now)
{
    if (finding.measure == Measure::none)
        return true;
    joint.tell(finding.why.code, to_sentence(finding.why));
    if (finding.measure == Measure::stop && whole_)
        return false;
    joint.end(now);
    joint.overrule(finding.why);
    joint.full_at_ = now; // whether it can do that, such as hold though it is hot
    if (finding.measure == Measure::stop) {
        joint.closed_by_ = finding.why;
        joint.closed_ = "it was stopped after a fault; enable the robot again";
    }
    return true;
}

/// A joint that its program did not ask has not fallen silent.
Finding Line::judge(Joint& joint, TimePoint now) const
{
    auto finding =
        joint.guard_.judge(joint.state_, joint.command_, joint.commanded_at_, joint.answered_at_, interval_, now);
    if (finding.measure == Measure::stop && finding.why.code == Errc::timeout)
        if (const auto paused = pause_.within(joint.answered_at_, now); paused > Duration{})
            finding.why.detail +=
                fmt::format(" But this program itself stood still for {:.2f} s before", seconds(paused));
    return finding;
}

Finding Line::judge(TimePoint now)
{
    for (Joint* joint : joints_) {
        if (joint->closed_ != nullptr)
            continue;
        auto finding = judge(*joint, now);
        if (!obey(*joint, finding, now))
            return finding;
    }
    return {};
}

Finding Line::begin_cycle(TimePoint now)
{
    clear();
    const Duration before = interval_;
    interval_ = begun_at_ == TimePoint{} ? Duration{} : now - begun_at_;
    begun_at_ = now;
    // The lesser of two: a loop that stood still for once is no slow one. Nor is one that waits for missing answers.
    for (Joint* joint : joints_)
        if (!joint->missing_since_)
            joint->interval_ = before > Duration{} ? std::min(before, interval_) : interval_;
    return judge(now);
}

void Line::plan_cycle(TimePoint now)
{
    clear();
    has_looked_ = false;
    const bool grouped = plan_group(now);
    for (Joint* joint : joints_) {
        if (joint->must_set_up_)
            if (const auto settings = plan(*joint, Beside::settings)) {
                add(*joint, settings->all());
                joint->must_set_up_ = false;
            }
        if (grouped && std::ranges::find(group_, joint) != group_.end())
            continue;
        const double resolution = joint->command_.resolution_rad.value_or(0.0) * joint->mounting_.ratio;
        auto requests = joint->plan(now, resolution);
        if (!requests) {
            const Error why = joint->named(std::move(requests.error()));
            joint->tell(why.code, to_sentence(why));
            joint->failed(why, now, nullptr);
            joint->hold_here(now);
            joint->overrule(why);
            requests = joint->plan(now, resolution);
        }
        if (requests)
            add(*joint, requests->all());
    }
    prepare_stop(now + (joints_.empty() ? Duration{} : joints_.front()->exchange_)); // who is sent away does not stay
    add_extras(now);
}

/// All motors of the bus with ids 1 to 4 in one frame, where all of them are driven by a current.
bool Line::plan_group(TimePoint now)
{
    if (group_.size() < 2)
        return false;
    const auto is_pushed = [now](const Joint* joint) {
        return (joint->command_.mode == Mode::current || joint->command_.mode == Mode::torque) &&
               !joint->must_set_up_ && joint->may_send(now);
    };
    if (!std::ranges::all_of(group_, is_pushed))
        return false;
    std::array<rmd::GroupMember, last_of_group> members;
    for (std::size_t i = 0; i < group_.size(); ++i)
        members[i] = {static_cast<rmd::Driver*>(group_[i]->driver_.get()),
                      group_[i]->mounting_.to_actuator(group_[i]->command_)};
    auto requests = rmd::plan_group(std::span(members).first(group_.size()));
    if (!requests)
        return false;
    for (const auto& request : requests->all()) {
        add(*group_.front(), {&request, 1});
        if (request.message->request.layout->can_fixed) {
            requests_[size_ - 1].replies = static_cast<std::uint8_t>(group_.size());
            owners_[size_ - 1] = nullptr;
        } else {
            const auto whose = std::ranges::find(group_, request.id, [](const Joint* j) { return id_of(j->device()); });
            owners_[size_ - 1] = whose != group_.end() ? *whose : group_.front();
        }
    }
    for (Joint* joint : group_) {
        joint->see_whether_it_turns_freely(now);
        joint->fresh_ = false;
        joint->repetitions_ = 0;
        joint->went_out(joint->mounting_.to_actuator(joint->command_), now);
        if (joint->raw_.position_rad)
            joint->guard_.follow(joint->mounting_.to_joint(*joint->raw_.position_rad), now);
        if (const auto read = joint->driver_->plan_read(Depth::motion))
            add(*joint, read->all().first(1));
    }
    return true;
}

std::expected<wire::Requests, Error> Line::plan(Joint& joint, Beside what)
{
    switch (what) {
    case Beside::settings:
        return joint.driver_->plan_settings();
    case Beside::full_state:
        return joint.driver_->plan_read(Depth::full);
    case Beside::reset_check:
        break;
    }
    return joint.driver_->plan_reset_check();
}

/// One joint a cycle, in turn: the rest of its state, and whether it has started afresh.
void Line::add_extras(TimePoint now)
{
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        Joint& joint = *joints_[(next_full_ + i) % joints_.size()];
        const bool full = now >= joint.full_at_, check = now >= joint.check_at_;
        if (!full && !check)
            continue;
        next_full_ = (next_full_ + i + 1) % joints_.size();
        if (full) {
            if (const auto read = plan(joint, Beside::full_state))
                add(joint, read->all());
            joint.full_at_ = now + between_full_readings;
        } else {
            if (const auto look = plan(joint, Beside::reset_check))
                add(joint, look->all());
            joint.check_at_ = now + between_reset_checks;
        }
        return;
    }
}

bool Line::must_look_first(TimePoint now) const
{
    return !has_looked_ && std::ranges::any_of(joints_, [&](const Joint* joint) {
        return joint->is_unplaced(now) && !joint->missing_since_;
    });
}

/// All of them: meanwhile the places of the others grow old.
void Line::plan_first_look(TimePoint now)
{
    clear();
    has_looked_ = true;
    for (Joint* joint : joints_)
        if (joint->holds_a_position_ && !joint->missing_since_) {
            joint->begins_anew_ = joint->begins_anew_ || joint->is_unplaced(now);
            (void)plan_read(*joint, Depth::motion);
        }
}

void Line::start()
{
    if (bus_->link_trouble() == nullptr && bus_->losses() != seen_losses_) {
        seen_losses_ = bus_->losses();
        back_since_ = joints_.empty() ? TimePoint{} : joints_.front()->now();
    }
    bus_->start(requests(), std::span(results_).first(size_));
    busy_ = true;
}

/// What is missing says nothing of that, nor who was not asked.
void Line::note_times()
{
    for (std::size_t i = 0; i < size_; ++i)
        if (owners_[i] != nullptr && results_[i].good)
            owners_[i]->answering_ = {};
    const int times = bus_->conversation().settings().double_read ? 2 : 1; // the time is that of the second
    for (std::size_t i = 0; i < size_; ++i)
        if (owners_[i] != nullptr && results_[i].good)
            owners_[i]->answering_ += times * (results_[i].at - results_[i].sent_at);
    note_exchange(exchange());
}

Duration Line::exchange() const
{
    Duration all{};
    for (const Joint* joint : joints_)
        all += joint->answering_;
    return all;
}

void Line::note_exchange(Duration time)
{
    for (Joint* joint : joints_)
        joint->exchange_ = time;
}

void Line::absorb(TimePoint now)
{
    busy_ = false;
    absorbed_at_ = now;
    note_times();
    const auto wire = bus_->conversation().line();
    for (std::size_t i = 0; i < size_; ++i) {
        const auto& request = requests_[i];
        const auto& result = results_[i];
        if (!result.good) {
            const TimePoint since = result.sent_at >= begun_at_ ? result.sent_at : result.at;
            if (owners_[i] != nullptr)
                owners_[i]->failed(result.error, since, &request);
            else
                for (Joint* joint : group_)
                    joint->failed(result.error, since, &request);
            continue;
        }
        if (!request.answered)
            continue;
        const auto replies = std::span(result.replies).first(result.reply_count);
        for (Joint* joint : owners_[i] != nullptr ? std::span(&owners_[i], 1) : std::span(group_)) {
            const auto own = owners_[i] != nullptr ? replies.begin() : find_reply_of(*joint, replies);
            if (own != replies.end())
                joint->absorb(request, *own, result.at - bus::frame_time(wire, own->size, bus::Stuffing::least));
            else
                joint->failed({.code = Errc::timeout}, result.at, &request);
        }
    }
    for (Joint* joint : joints_)
        look_after(*joint, now);
}

void Line::look_after(Joint& joint, TimePoint now)
{
    joint.state_ = joint.mounting_.to_joint(joint.raw_, joint.driver_->capabilities().current_has_sign);
    joint.guard_.observe(joint.state_);
    joint.stillness_.look(joint.state_.position_rad);
    joint.see_whether_it_has_heard();
    const std::string_view reset = joint.driver_->noticed_reset();
    const bool is_afresh = joint.counts_from_power_on() && (!reset.empty() || joint.leapt_ || joint.is_back());
    if (joint.driver_->take_lost_count() || is_afresh)
        joint.forget_reference();
    if (joint.closed_ != nullptr && !joint.closed_by_) {
        if (joint.is_back()) { // where it held before, it may hold no more
            joint.silence_.reset();
            joint.is_held_ = false;
        }
        return;
    }
    if (!reset.empty() && !joint.must_set_up_)
        joint.start_afresh(fmt::format("{} has started afresh: {}", joint.name(), reset), now);
    else if (joint.leapt_)
        joint.start_afresh(fmt::format("{} has turned further between two answers than it may, and may have started "
                                       "afresh where it stands",
                                       joint.name()),
                           now);
    else if (joint.is_back())
        joint.start_afresh(fmt::format("{} did not answer for {:.2f} s and may have started afresh", joint.name(),
                                       seconds(joint.silence_->lasted)),
                           now);
}

} // namespace sinew::robot
