#include "sinew/robot/sequence.hpp"

#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/pose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace sinew::robot {
namespace {

using config::Condition;
using config::Step;

constexpr int most_steps_a_call = 64; ///< of those that take no time; the next call goes on

/// What a condition looks at, if it was measured since.
std::optional<double> measured(const actuator::Measured<double>& value, TimePoint since)
{
    return value && value.at() >= since ? value.optional() : std::nullopt;
}

struct Shown {
    std::string_view name, unit;
    double per_si = 1.0;
};

Shown shown(Condition::Of of)
{
    switch (of) {
    case Condition::Of::position:
        return {"position", "deg", units::deg(1.0)};
    case Condition::Of::speed:
        return {"speed", "deg/s", units::deg(1.0)};
    case Condition::Of::current:
        return {"current", "A", 1.0};
    }
    return {};
}

std::optional<double> look(const Condition& condition, std::span<const actuator::State> states, TimePoint since)
{
    if (condition.joint >= states.size())
        return {};
    const actuator::State& state = states[condition.joint];
    if (condition.of == Condition::Of::position)
        return measured(state.position_rad, since);
    const auto value = measured(condition.of == Condition::Of::speed ? state.velocity_rad_s : state.current_a, since);
    return value ? std::optional(std::abs(*value)) : std::nullopt;
}

} // namespace

std::string to_words(const config::RobotFile& file, const Condition& condition, std::string_view verb)
{
    const auto [name, unit, per_si] = shown(condition.of);
    return fmt::format("the {} of {} {} {} {:g} {}", name, file.joints[condition.joint].name, verb,
                       condition.above ? "above" : "below", condition.value * per_si, unit);
}

SequencePlayer::SequencePlayer(const config::RobotFile& file, const config::Sequence& sequence, double speed)
    : file_(&file), speed_(speed)
{
    const std::size_t joints = file.joints.size();
    targets_.resize(joints);
    plan_.reserve(joints);
    wanted_.reserve(joints);
    moving_.reserve(joints);
    enter(sequence.steps, 1);
}

SequencePlayer::Status SequencePlayer::next(TimePoint now, States states)
{
    if (phase_ == Phase::ended)
        return status_;
    const Duration passed = called_at_ ? std::max(Duration{}, now - *called_at_) : Duration{};
    const bool waits = std::exchange(waits_, false);
    const Duration gone_on = waits ? Duration{} : std::min(passed, longest_step);
    waited_ += waits ? std::min(passed, longest_step) : Duration{};
    time_ += gone_on;
    delayed_ += passed - gone_on;
    called_at_ = now;
    if (stop_asked_ && phase_ != Phase::slowing_down)
        slow_down(Status::stopped);
    if (stop_asked_ && then_ == Status::running)
        then_ = Status::stopped;
    carry_on(states);
    for (int step = 0; step < most_steps_a_call && phase_ == Phase::between; ++step) {
        begin_next(states);
        carry_on(states);
    }
    for (const Moving& one : moving_)
        targets_[one.joint] = one.way.at(time_ - motion_begun_);
    return status_;
}

void SequencePlayer::enter(const std::vector<Step>& steps, std::optional<std::int64_t> times)
{
    if (depth_ < frames_.size() && !steps.empty())
        frames_[depth_++] = {.steps = &steps, .next = 0, .more = times ? std::optional(*times - 1) : std::nullopt};
}

void SequencePlayer::begin_next(States states)
{
    while (depth_ > 0 && frames_[depth_ - 1].next == frames_[depth_ - 1].steps->size()) {
        Frame& frame = frames_[depth_ - 1];
        if (frame.more == 0) {
            --depth_;
            continue;
        }
        if (frame.more)
            --*frame.more;
        frame.next = 0;
    }
    if (depth_ == 0) {
        end(Status::done);
        return;
    }
    Frame& frame = frames_[depth_ - 1];
    const Step& step = (*frame.steps)[frame.next++];
    if (step.kind == Step::Kind::repeat) {
        enter(step.steps, step.times);
        return;
    }
    if (step.kind == Step::Kind::call) {
        enter(file_->sequences[step.sequence].steps, step.times);
        return;
    }
    step_ = &step;
    ++steps_begun_;
    step_call_at_ = *called_at_;
    step_waited_ = waited_;
    phase_ = Phase::carrying_out;
    if (step.kind == Step::Kind::move)
        if (auto begun = begin_move(step, states); !begun)
            fail(std::move(begun.error()));
}

std::expected<void, Error> SequencePlayer::begin_move(const Step& step, States states)
{
    wanted_.clear();
    for (const config::JointTarget& target : step.targets) {
        const config::Joint& joint = file_->joints[target.joint];
        std::optional<double> from;
        if (targets_[target.joint])
            from = targets_[target.joint]->position_rad;
        else if (target.joint < states.size())
            from = states[target.joint].position_rad.optional();
        if (!from)
            return std::unexpected(at_step(Errc::bad_argument, joint.name + " did not tell its position yet"));
        wanted_.push_back({.from_rad = *from,
                           .target_rad = target.position_rad,
                           .limits = slowed(motion_limits(joint), speed_ * step.speed)});
    }
    const auto duration = step.duration_s ? std::optional(from_seconds(*step.duration_s)) : std::nullopt;
    if (auto planned = plan_.plan(wanted_, duration); !planned) {
        const auto index = static_cast<std::size_t>(planned.error().value);
        return std::unexpected(
            at_step(planned.error().code, fmt::format("{}: {}", file_->joints[step.targets[index].joint].name,
                                                      to_sentence(planned.error()))));
    }
    moving_.clear();
    for (std::size_t i = 0; i < step.targets.size(); ++i)
        moving_.push_back({.joint = step.targets[i].joint, .way = plan_.joint(i)});
    motion_begun_ = step_begun_;
    motion_duration_ = plan_.duration();
    ++motions_;
    return {};
}

/// Sees whether what is on its way is over by now.
void SequencePlayer::carry_on(States states)
{
    const bool arrived = time_ - motion_begun_ >= motion_duration_;
    if (!moving_.empty() && arrived)
        settle();
    if (phase_ == Phase::slowing_down && moving_.empty())
        go_on(motion_begun_ + motion_duration_);
    if (phase_ != Phase::carrying_out)
        return;
    if (step_->until) {
        const bool met = is_met(*step_->until, states);
        const bool over = time_ - step_begun_ + waited_ - step_waited_ >= from_seconds(step_->until->within_s);
        if (met || (over && step_->until->goes_on))
            slow_down(Status::running);
        else if (over)
            fail(not_met(*step_->until, states));
    } else if (step_->kind == Step::Kind::move) {
        if (moving_.empty())
            finish_step(motion_begun_ + motion_duration_);
    } else if (const Duration over = step_begun_ + from_seconds(step_->duration_s.value_or(0.0)); time_ >= over) {
        finish_step(over);
    }
}

bool SequencePlayer::is_met(const Condition& condition, States states) const
{
    const auto value = look(condition, states, step_call_at_);
    return value && (condition.above ? *value > condition.value : *value < condition.value);
}

Error SequencePlayer::not_met(const Condition& condition, States states) const
{
    const auto [name, unit, per_si] = shown(condition.of);
    const auto value = look(condition, states, step_call_at_);
    const std::string was = value ? fmt::format("it was {:.4g} {}", *value * per_si, unit) : "it was not measured";
    return at_step(Errc::timeout, fmt::format("{} within {:g} s; {}", to_words(*file_, condition, "was not"),
                                              condition.within_s, was));
}

void SequencePlayer::finish_step(Duration at)
{
    phase_ = Phase::between;
    step_begun_ = at;
}

/// Everything stands.
void SequencePlayer::go_on(Duration at)
{
    if (then_ == Status::running)
        finish_step(at);
    else
        end(then_);
}

/// From now on everything that moves comes to rest.
void SequencePlayer::slow_down(Status then)
{
    phase_ = Phase::slowing_down;
    then_ = then;
    if (moving_.empty()) {
        go_on(time_);
        return;
    }
    Duration longest{};
    for (Moving& one : moving_) {
        const Setpoint now = one.way.at(time_ - motion_begun_);
        const auto stop =
            Trajectory::stop(now.position_rad, now.velocity_rad_s, motion_limits(file_->joints[one.joint]));
        if (stop)
            one.way = *stop;
        longest = std::max(longest, one.way.duration());
    }
    ++motions_;
    motion_begun_ = time_;
    motion_duration_ = longest;
}

/// What moved stands on its target.
void SequencePlayer::settle()
{
    for (const Moving& one : moving_)
        targets_[one.joint] = one.way.at(motion_duration_);
    moving_.clear();
}

void SequencePlayer::fail(Error error)
{
    error_ = std::move(error);
    slow_down(Status::failed);
}

void SequencePlayer::end(Status status)
{
    phase_ = Phase::ended;
    status_ = status;
    step_ = nullptr;
}

Error SequencePlayer::at_step(Errc code, std::string_view says) const
{
    Error error{.code = code};
    const config::Mark at = step_->at;
    error.detail = at.line > 0 ? fmt::format("{}:{}:{}: {}", file_->path, at.line, at.column, says) : std::string{says};
    return error;
}

} // namespace sinew::robot
