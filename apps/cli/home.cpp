#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/home_stop.hpp"
#include "apps/cli/moving.hpp"
#include "sinew/base/seconds.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/stop_search.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

constexpr double default_speed_rad_s = units::rad(15.0);

/// A joint whose limit is lower is as slow as it must be, unless the words insist.
double speed_of(const Device& device, double wanted_rad_s)
{
    if (device.joint == nullptr || !device.joint->velocity_max_rad_s.has_value())
        return wanted_rad_s;
    return std::min(wanted_rad_s, device.joint->velocity_max_rad_s.value());
}

Outcome home_one(const Words& words, Session& session, Device device, double speed_rad_s)
{
    auto driven = drive_and_read(session, std::move(device));
    if (!driven)
        return std::unexpected(driven.error());
    if (!words.json())
        fmt::print("{}\n", driven->device.name);
    show_state(words, *driven, {});
    if (driven->device.joint != nullptr && driven->device.joint->home.to_stop) {
        const auto ended = find_stop(words, session, *driven);
        if (!ended)
            return std::unexpected(ended.error());
        if (*ended)
            return **ended;
    }
    const auto from = known_position_of(*driven);
    if (!from)
        return std::unexpected(from.error());
    const auto needed = from_seconds(2.0 * std::abs(*from) / speed_rad_s);
    return move_to(words, session, *driven, {.speed_rad_s = speed_rad_s, .limit = std::chrono::seconds(60) + needed});
}

Outcome run(const Words& words)
{
    double speed_rad_s = default_speed_rad_s;
    if (const auto word = words.text("--speed")) {
        const auto speed = speed_from(*word);
        if (!speed)
            return std::unexpected(speed.error());
        speed_rad_s = *speed;
    }
    auto devices = targets(words);
    if (!devices)
        return std::unexpected(devices.error());
    std::vector<std::string_view> names;
    for (const auto& device : *devices) {
        const double speed = words.has("--speed") ? speed_rad_s : speed_of(device, speed_rad_s);
        if (auto fine = check_limits(device, 0.0, speed); !fine)
            return std::unexpected(fine.error());
        names.push_back(device.name);
    }
    std::string question = fmt::format("{} will turn to zero{}, at {:g} deg/s at most", fmt::join(names, ", "),
                                       names.size() > 1 ? ", one after the other" : "", units::deg(speed_rad_s));
    for (const auto& device : *devices)
        if (device.joint != nullptr && device.joint->home.to_stop)
            question += fmt::format(
                "; {} first turns {} with {:g} deg/s until something stops it, for {:.0f} deg at most", device.name,
                device.joint->home.direction > 0 ? "up" : "down", units::deg(robot::home_velocity_rad_s(*device.joint)),
                units::deg(robot::longest_search_rad(*device.joint)));
    const auto yes = confirm(words, question);
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    Session session;
    for (auto& device : *devices) {
        const double speed = speed_of(device, speed_rad_s);
        const auto done = home_one(words, session, std::move(device), speed);
        if (!done || *done != exit_done)
            return done;
    }
    return exit_done;
}

} // namespace

Verb home_verb()
{
    return {
        .name = "home",
        .says = "Turn a joint, or all of a robot one after the other, slowly to zero.",
        .arguments = {{"TARGET", "a joint, or a link with --family and --id; without it all joints of --robot", false}},
        .options = with_device_options({{"--speed", "S", "how fast, such as 30deg/s; 15deg/s where it is not given"},
                                        yes_option,
                                        {"--json", "", "print one object per look and line"}}),
        .examples = {{"sinew home elbow --robot arm.toml", "asks first"},
                     {"sinew home --robot arm.toml --sim --yes", "a whole robot, simulated"},
                     {"sinew home slcan:/dev/ttyACM0 --family rmd --id 1 --speed 5deg/s --yes", "a device on a link"}},
        .run = run,
        .acts = true,
        .more =
            "A joint with `[joint.NAME.home] routine = \"stop\"` first turns until something stops it, and counts from "
            "there: its position_deg is where the stop is. It finds none where it has turned as far as travel_max_deg "
            "says, or else through all of its range and 20 deg more; then it is brought to rest. A SAM knows no speed "
            "for a move to a position; it is led in "
            "small steps. Ctrl-C makes a joint stay "
            "where it is. A joint that does not arrive holds there, and ends it.",
        .ends = {exit_at_limit}};
}

} // namespace sinew::cli
