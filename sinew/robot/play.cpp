#include "sinew/robot/play.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/pose.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::robot {
namespace {

using Status = SequencePlayer::Status;

constexpr double longest_lag_s = 0.02;
constexpr double near_rad = units::rad(0.5);
constexpr Duration longest_trail = std::chrono::milliseconds{500}; ///< a joint that carries a load may never be nearer

/// One sequence on one robot.
class Performance
{
public:
    Performance(Robot& robot, const config::Sequence& sequence, const PlayOptions& options)
        : robot_(robot), options_(options), player_(robot.file(), sequence, options.speed * speed_kept),
          states_(robot.joints().size())
    {
        for (const Joint& joint : robot.joints())
            watched_.push_back({.overruled = joint.overruled()});
    }

    std::expected<Status, Error> run()
    {
        if (auto ran = robot_.run(options_.period, [this](Robot&) { turn(); }); !ran)
            return std::unexpected(std::move(ran.error()));
        if (auto settled = settle(); !settled)
            return std::unexpected(std::move(settled.error()));
        if (refused_)
            return std::unexpected(std::move(*refused_));
        if (status_ == Status::failed)
            return std::unexpected(player_.error());
        return status_;
    }

private:
    void turn()
    {
        if (status_ != Status::running)
            return;
        const auto joints = robot_.joints();
        for (std::size_t i = 0; i < joints.size(); ++i)
            states_[i] = joints[i].state();
        if (options_.stop_asked && options_.stop_asked())
            player_.stop();
        status_ = player_.next(robot_.clock().now(), states_);
        for (std::size_t i = 0; i < joints.size(); ++i)
            if (player_.targets()[i]) {
                send(joints[i], i);
                wait_for(joints[i], i);
            }
        sent_ = player_.motions();
        if (options_.each)
            options_.each(player_);
        if (status_ != Status::running)
            robot_.leave();
    }

    void send(Joint& joint, std::size_t index)
    {
        Watched& watched = watched_[index];
        if (watched.is_given_up)
            return;
        if (joint.overruled() != watched.overruled) {
            watched.is_given_up = true;
            return give_up(*joint.overruled_by());
        }
        const auto& can = joint.capabilities();
        const bool plans_itself = can.timed && can.timing == actuator::Timing::by_device;
        std::expected<void, Error> set;
        if (!plans_itself)
            set = stream(joint, player_.targets()[index]->position_rad);
        else if (sent_ == player_.motions())
            joint.renew();
        else
            set = send_motion(joint, index);
        if (!set)
            give_up(std::move(set.error()));
    }

    /// The others slow down, and all hold.
    void give_up(Error why)
    {
        if (!refused_)
            refused_ = std::move(why);
        player_.stop();
    }

    /// A joint that does not follow keeps the motion waiting, for a while.
    void wait_for(Joint& joint, std::size_t index)
    {
        Watched& watched = watched_[index];
        const Setpoint& target = *player_.targets()[index];
        const auto& at = joint.state().position_rad;
        const bool leads_away = at && (target.position_rad - *at) * target.velocity_rad_s > 0.0;
        const bool is_behind =
            !watched.is_given_up && !player_.slowing_down() && leads_away && joint.is_behind(target.position_rad);
        if (is_behind)
            player_.wait();
        // What goes at once wherever it is led is judged by its supervisor, and its end seen by `send`.
        const bool is_own_affair = static_cast<bool>(joint.capabilities().velocity_limit);
        if (!watched.following.is_blocked(at, target.position_rad, is_behind && is_own_affair))
            return;
        watched.is_given_up = true;
        (void)joint.set({.mode = Mode::hold});
        give_up({.code = Errc::timeout,
                 .detail = fmt::format("{}: {}", joint.name(), does_not_follow(*at, target.position_rad))});
    }

    /// What a late loop or a slow bus leaves behind is made up for before the motion goes on.
    std::expected<void, Error> stream(Joint& joint, double target_rad)
    {
        const double step_rad = joint.nearest_step_rad(target_rad);
        if (!refused_ && std::abs(target_rad - step_rad) > motion_limits(joint.file()).velocity_rad_s * longest_lag_s)
            player_.wait();
        return joint.set({.mode = Mode::position, .position_rad = step_rad});
    }

    /// A motion as a whole.
    std::expected<void, Error> send_motion(Joint& joint, std::size_t index)
    {
        const auto moving = player_.moving();
        const auto own = std::ranges::find(moving, index, &SequencePlayer::Moving::joint);
        if (own == moving.end() || own->way.duration() == Duration{})
            return {};
        if (player_.slowing_down())
            return joint.set({.mode = Mode::hold});
        return joint.set(
            {.mode = Mode::position, .position_rad = own->way.target_rad(), .duration = own->way.duration()});
    }

    /// The last targets go out on the slowest bus, too, and joints trail a little behind them.
    std::expected<void, Error> settle()
    {
        double slowest_s = seconds(options_.period);
        for (const config::Bus& bus : robot_.file().buses)
            slowest_s = std::max(slowest_s, bus.rate_hz ? 1.0 / *bus.rate_hz : 0.0);
        const TimePoint sent = robot_.clock().now() + from_seconds(2.0 * slowest_s);
        return robot_.run(
            options_.period,
            [&](Robot&) {
                // There is nothing left to slow down; who asks has no other way to be heard.
                if (options_.stop_asked && options_.stop_asked() && status_ == Status::done)
                    status_ = Status::stopped;
                if (robot_.clock().now() >= sent && have_arrived())
                    robot_.leave();
            },
            sent + longest_trail);
    }

    bool have_arrived()
    {
        bool all = true;
        const auto joints = robot_.joints();
        for (std::size_t i = 0; i < joints.size(); ++i)
            if (const auto& target = player_.targets()[i]) {
                send(joints[i], i);
                const auto& at = joints[i].state().position_rad;
                all = all && at && std::abs(*at - target->position_rad) <= near_rad;
            }
        return all;
    }

    Robot& robot_;
    const PlayOptions& options_;
    SequencePlayer player_;
    Status status_ = Status::running;
    std::vector<State> states_;
    std::uint64_t sent_ = 0; ///< motions
    struct Watched {
        std::uint64_t overruled = 0; ///< when this began
        Following following{};
        bool is_given_up = false;
    };
    std::vector<Watched> watched_; ///< by joint
    std::optional<Error> refused_;
};

std::expected<config::JointTarget, Error> find(Robot& robot, const NamedTarget& target)
{
    const auto joints = robot.joints();
    const auto at = std::ranges::find(joints, target.joint, &Joint::name);
    if (at == joints.end())
        return std::unexpected(robot.set(target.joint, {}).error());
    const auto fine = actuator::check({.mode = Mode::position, .position_rad = target.position_rad},
                                      actuator::Limits{.position_low_rad = at->limits().position_low_rad,
                                                       .position_high_rad = at->limits().position_high_rad},
                                      at->state(), id_of(at->device()));
    if (!fine)
        return std::unexpected(fine.error());
    return config::JointTarget{.joint = static_cast<std::size_t>(at - joints.begin()),
                               .position_rad = target.position_rad};
}

} // namespace

std::expected<Status, Error> play(Robot& robot, const config::Sequence& sequence, const PlayOptions& options)
{
    if (!(options.speed > 0.0 && options.speed <= 1.0))
        return fail(Errc::bad_argument, "the speed of a sequence is a share above 0 up to 1");
    return Performance(robot, sequence, options).run();
}

std::expected<Status, Error> move(Robot& robot, std::span<const NamedTarget> targets, std::optional<Duration> duration,
                                  const PlayOptions& options)
{
    config::Sequence sequence{.name = "move"};
    config::Step step{.kind = config::Step::Kind::move};
    for (const NamedTarget& target : targets) {
        const auto found = find(robot, target);
        if (!found)
            return std::unexpected(found.error());
        if (std::ranges::find(step.targets, found->joint, &config::JointTarget::joint) != step.targets.end())
            return fail(Errc::bad_argument, fmt::format("{} can only go to one place at a time", target.joint));
        step.targets.push_back(*found);
    }
    if (duration)
        step.duration_s = seconds(*duration);
    if (!step.targets.empty())
        sequence.steps.push_back(std::move(step));
    return play(robot, sequence, options);
}

} // namespace sinew::robot
