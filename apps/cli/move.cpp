#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/help.hpp"
#include "apps/cli/robot_record.hpp"
#include "apps/cli/turning.hpp"
#include "sinew/base/units.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::expected<Goal, Error> goal_from(const Words& words)
{
    if (!words.has("POSITION"))
        return fail(Errc::bad_argument, fmt::format("POSITION is missing; write {}", usage(move_verb())));
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
    goal.limit = limit->value_or(goal.limit + goal.duration.value_or(Duration{}));
    return goal;
}

template <class Do>
Outcome ask_and_do(const Words& words, Device device, std::string_view question, const Do& what)
{
    const auto yes = confirm(words, question);
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    const auto record = DeviceRecord::make(words);
    if (!record)
        return std::unexpected(record.error());
    Session session;
    auto driven = drive_and_read(session, std::move(device));
    if (!driven)
        return std::unexpected(driven.error());
    if (*record)
        (*record)->watch(session, *driven);
    show_state(words, *driven, {});
    return recorded(what(session, *driven), record->get());
}

Outcome run_turning(const Words& words, const Turning& turning)
{
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (auto fine = check_limits(*device, turning); !fine)
        return std::unexpected(fine.error());
    const auto question = describe(*device, turning);
    return ask_and_do(words, std::move(*device), question,
                      [&](Session& session, Driven& driven) { return turn_on(words, session, driven, turning); });
}

Outcome run(const Words& words)
{
    const auto turning = turning_from(words);
    if (!turning)
        return std::unexpected(turning.error());
    if (*turning)
        return run_turning(words, **turning);
    const auto goal = goal_from(words);
    if (!goal)
        return std::unexpected(goal.error());
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (auto fine = check_limits(*device, goal->position_rad, goal->speed_rad_s); !fine)
        return std::unexpected(fine.error());
    const auto question = fmt::format("{} will move to {:g} deg", device->name, units::deg(goal->position_rad));
    return ask_and_do(words, std::move(*device), question,
                      [&](Session& session, Driven& driven) { return move_to(words, session, driven, *goal); });
}

} // namespace

Verb move_verb()
{
    return {
        .name = "move",
        .says = "Move a joint to a position and show it until it has arrived, or drive it for a time.",
        .arguments = {target_argument,
                      {"POSITION", "an angle with its unit, such as 90deg, 1.57rad or 0.25turn", false}},
        .options = with_device_options({{"--speed", "S", "no faster than this, such as 30deg/s or 5rpm"},
                                        {"--in", "TIME", "arrive after this time, such as 2s; not SAM"},
                                        {"--within", "TIME", "give up after this time; 60s where it is not given"},
                                        {"--velocity", "S", "turn at this speed instead, such as -30deg/s"},
                                        {"--current", "I", "drive with this current instead, such as 0.5A; RMD"},
                                        {"--torque", "T", "drive with this torque instead, such as 0.2Nm"},
                                        {"--for", "TIME", "how long, with --velocity, --current or --torque"},
                                        record_option,
                                        yes_option,
                                        {"--json", "", "print one object per look and line"}}),
        .examples = {{"sinew move elbow 45deg --robot arm.toml", "asks first"},
                     {"sinew move waist_yaw 30deg --in 2s --robot arm.toml --yes", "takes its time"},
                     {"sinew move left_hip --velocity -20deg/s --for 1s --robot arm.toml --yes", "then it holds"},
                     {"sinew move left_ankle --current 0.2A --for 100ms --robot arm.toml --sim --yes",
                      "then it is released"},
                     {"sinew move elbow 45deg --robot arm.toml --sim --yes --record run.mcap",
                      "for sinew plot and sinew export"},
                     {"sinew move serial:/dev/ttyUSB0 -10deg --family nuri --id 1 --speed 5rpm --yes", "does not ask"}},
        .run = run,
        .acts = true,
        .more =
            "Ctrl-C makes it stay where it is, and so does whatever else ends it on the way. The limits of the robot "
            "file hold for what is sent and for what is measured: speed, current, heat and faults too. A SAM knows no "
            "speed for a move; with one it is led in small steps. What a device cannot do is refused; a torque needs a "
            "known torque constant.",
        .ends = {exit_at_limit}};
}

} // namespace sinew::cli
