#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration step = std::chrono::milliseconds(100);       ///< between two looks
constexpr Duration standstill = std::chrono::milliseconds(800); ///< so long without progress is a stop
constexpr int most_looks_at_a_stop = 20;
constexpr Duration default_limit = std::chrono::seconds(60);

struct Goal {
    double position_rad = 0.0; ///< of the joint
    double tolerance_rad = 0.0;
    std::optional<double> speed_rad_s;
    std::optional<Duration> duration;
    Duration limit{};
};

std::expected<Goal, Error> goal_from(const Words& words)
{
    const auto position = angle_from(*words.text("POSITION"));
    if (!position)
        return std::unexpected(position.error());
    Goal goal{.position_rad = *position};
    if (const auto word = words.text("--speed")) {
        const auto speed = speed_from(*word);
        if (!speed)
            return std::unexpected(speed.error());
        goal.speed_rad_s = *speed;
    }
    const auto duration = words.duration("--in");
    if (!duration)
        return std::unexpected(duration.error());
    goal.duration = *duration;
    if (goal.duration && goal.speed_rad_s)
        return fail(Errc::bad_argument, "a move has a speed or a duration: give --speed or --in, not both");
    const auto limit = words.duration("--within");
    if (!limit)
        return std::unexpected(limit.error());
    goal.limit = limit->value_or(default_limit + goal.duration.value_or(Duration{}));
    return goal;
}

void show_state(const Words& words, const Driven& driven, Duration since_start)
{
    if (words.json()) {
        print_line(state_json(driven, since_start));
        return;
    }
    const auto cells = state_cells(driven);
    std::string line = fmt::format("{:6.2f} s", seconds(since_start));
    for (const auto& cell : cells)
        if (!cell.empty() && cell != "none")
            line += fmt::format("  {:>12}", cell);
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

double position_of(const Driven& driven)
{
    return to_joint_position(driven.device.joint, driven.state.position_rad.value_or(0.0));
}

/// Stays where it is after Ctrl-C, with torque.
Outcome stop_here(Session& session, Driven& driven)
{
    clear_interrupt();
    if (const auto held = hold(driven); !held)
        return std::unexpected(held.error());
    // It slows down first; what is said is where it stands.
    std::optional<double> before;
    for (int look = 0; look < most_looks_at_a_stop; ++look) {
        if (!read_state(driven, actuator::Depth::motion) || !driven.state.position_rad)
            break;
        if (before == driven.state.position_rad) {
            fmt::print(stderr, "Stopped; it holds at {:.2f} deg.\n", units::deg(position_of(driven)));
            return exit_interrupted;
        }
        before = driven.state.position_rad;
        wait_until(session, session.clock().now() + step);
    }
    fmt::print(stderr, "It was told to hold, but it does not stand still yet.\n");
    return exit_interrupted;
}

std::expected<void, Error> start(Driven& driven, const Goal& goal)
{
    const auto* joint = driven.device.joint;
    actuator::Command command{.mode = actuator::Mode::position,
                              .position_rad = to_actuator_position(joint, goal.position_rad)};
    command.duration = goal.duration;
    if (goal.duration) {
        const double mean_speed = std::abs(goal.position_rad - position_of(driven)) / seconds(*goal.duration);
        if (auto fine = check_limits(driven.device, goal.position_rad, mean_speed); !fine)
            return fine;
    }
    // The limit of the robot file is also the speed of a move that names none.
    auto speed = goal.speed_rad_s;
    if (!speed && !goal.duration && joint != nullptr && driven.driver->capabilities().velocity_limit)
        speed = joint->velocity_max_rad_s;
    if (speed)
        command.velocity_rad_s = *speed * (joint != nullptr ? std::abs(joint->ratio) : 1.0);
    const auto requests = driven.driver->plan(command, driven.state);
    return requests ? carry_out(driven, *requests) : std::unexpected(requests.error());
}

/// Looks until it has arrived, stands still or the time is over.
Outcome follow(const Words& words, Session& session, Driven& driven, const Goal& goal)
{
    const TimePoint begin = session.clock().now();
    // A move that takes its time may begin too gently to be seen.
    TimePoint progressed = begin + goal.duration.value_or(Duration{});
    double last = position_of(driven);
    for (TimePoint look = begin + step;; look += step) {
        wait_until(session, look);
        auto read = interrupted() ? std::expected<void, Error>{} : read_state(driven, actuator::Depth::motion);
        if (interrupted())
            return stop_here(session, driven);
        if (!read)
            return std::unexpected(read.error());
        const TimePoint now = session.clock().now();
        show_state(words, driven, now - begin);
        const double here = position_of(driven);
        if (std::abs(here - goal.position_rad) <= goal.tolerance_rad)
            return exit_done;
        if (std::abs(here - last) > goal.tolerance_rad / 10.0) {
            progressed = std::max(progressed, now);
            last = here;
        }
        if (now - progressed > standstill)
            return fail(Errc::unsupported,
                        fmt::format("{} stands still at {:.2f} deg, short of {:.2f} deg; is something in its way, or "
                                    "is it switched off?",
                                    driven.device.name, units::deg(here), units::deg(goal.position_rad)));
        if (now - begin > goal.limit)
            return fail(Errc::timeout,
                        fmt::format("{} is at {:.2f} deg after {:g} s and still moves; --within gives it more time",
                                    driven.device.name, units::deg(here), seconds(goal.limit)));
    }
}

Outcome run(const Words& words)
{
    auto goal = goal_from(words);
    if (!goal)
        return std::unexpected(goal.error());
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (auto fine = check_limits(*device, goal->position_rad, goal->speed_rad_s); !fine)
        return std::unexpected(fine.error());
    const auto yes =
        confirm(words, fmt::format("{} will move to {:g} deg", device->name, units::deg(goal->position_rad)));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    Session session;
    auto driven = drive(session, std::move(*device));
    if (!driven)
        return std::unexpected(driven.error());
    if (auto set = set_up(*driven); !set)
        return std::unexpected(set.error());
    if (auto read = read_state(*driven, actuator::Depth::full); !read)
        return std::unexpected(read.error());
    show_state(words, *driven, {});
    // Where a device stops within is not documented; half a degree is what the coarsest of them can tell.
    const double finest = 2.0 * driven->driver->capabilities().position_step_rad;
    goal->tolerance_rad = std::max(units::rad(0.5), finest);
    if (auto started = start(*driven, *goal); !started) {
        // The command may be out although nobody acknowledged it.
        const auto code = started.error().code;
        if (code == Errc::stopped)
            return stop_here(session, *driven);
        if (code == Errc::timeout || code == Errc::bad_reply)
            (void)hold(*driven);
        return std::unexpected(started.error());
    }
    return follow(words, session, *driven, *goal);
}

} // namespace

Verb move_verb()
{
    return {
        .name = "move",
        .says = "Move a joint to a position and show it until it has arrived.",
        .arguments = {target_argument, {"POSITION", "an angle with its unit, such as 90deg, 1.57rad or 0.25turn"}},
        .options = with_device_options({{"--speed", "S", "no faster than this, such as 30deg/s or 5rpm"},
                                        {"--in", "TIME", "arrive after this time, such as 2s; not SAM"},
                                        {"--within", "TIME", "give up after this time; 60s where it is not given"},
                                        yes_option,
                                        {"--json", "", "print one object per look and line"}}),
        .examples = {{"sinew move elbow 45deg --robot arm.toml", "asks first"},
                     {"sinew move waist_yaw 30deg --in 2s --robot arm.toml --yes", "takes its time"},
                     {"sinew move serial:/dev/ttyUSB0 -10deg --family nuri --id 1 --speed 5rpm --yes", "does not ask"}},
        .run = run,
        .more = "Ctrl-C makes it stay where it is. Giving up does not stop it: `sinew stop` does."};
}

} // namespace sinew::cli
