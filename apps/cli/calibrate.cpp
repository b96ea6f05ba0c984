#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

constexpr Duration period = std::chrono::milliseconds(50);

/// A joint that is turned by hand, and how far it was turned. Positions are those of the actuator.
struct Turned {
    Driven driven;
    double middle_rad = 0.0;
    double low_rad = 0.0, high_rad = 0.0;
    double at_rad = 0.0;
};

/// As the joint counts from the middle; the lower one first, whatever its direction.
std::pair<double, double> limits(const Turned& one)
{
    const auto in_joint = [&](double actuator_rad) {
        return to_joint_velocity(one.driven.device.joint, actuator_rad - one.middle_rad);
    };
    return std::minmax({in_joint(one.low_rad), in_joint(one.high_rad)}, std::less<>{});
}

std::expected<void, Error> look(Turned& one)
{
    if (auto read = read_state(one.driven, actuator::Depth::motion); !read)
        return read;
    one.at_rad = one.driven.state.position_rad.value_or(one.at_rad);
    one.low_rad = std::min(one.low_rad, one.at_rad);
    one.high_rad = std::max(one.high_rad, one.at_rad);
    return {};
}

std::expected<std::vector<Turned>, Error> open_released(Session& session, std::vector<Device> devices)
{
    std::vector<Turned> all;
    for (auto& device : devices) {
        auto driven = drive(session, std::move(device));
        if (!driven)
            return std::unexpected(driven.error());
        const auto requests = driven->driver->plan({.mode = actuator::Mode::release}, {});
        if (!requests)
            return std::unexpected(requests.error());
        if (auto sent = carry_out(*driven, *requests); !sent)
            return std::unexpected(sent.error());
        all.push_back({.driven = std::move(*driven)});
    }
    return all;
}

void show_table(const std::vector<Turned>& all, bool first)
{
    Table table({"NAME", "MIN", "POS", "MAX"});
    for (const auto& one : all) {
        const auto [low, high] = limits(one);
        const double at = to_joint_velocity(one.driven.device.joint, one.at_rad - one.middle_rad);
        const auto deg = [](double rad) { return fmt::format("{:8.2f}", units::deg(rad) + 0.0); };
        table.add({one.driven.device.name, deg(low), deg(at), deg(high)});
    }
    if (!first)
        fmt::print(stderr, "\033[{}A", all.size() + 1);
    fmt::print(stderr, "{}", table.text());
}

/// Takes the present position of each for its middle.
std::expected<void, Error> take_middle(std::vector<Turned>& all)
{
    for (auto& one : all) {
        if (auto read = look(one); !read)
            return read;
        one.middle_rad = one.low_rad = one.high_rad = one.at_rad;
    }
    return {};
}

/// Until Enter or the end of the time; false: the input has ended before.
std::expected<bool, Error> watch_hands(Session& session, std::vector<Turned>& all, std::optional<Duration> time)
{
    const bool live = stderr_is_terminal();
    const TimePoint begin = session.clock().now();
    const TimePoint end = time ? begin + *time : TimePoint::max();
    bool first = true;
    for (TimePoint next = begin; next < end && !interrupted(); next += period) {
        wait_until(session, next);
        if (const auto key = time ? Typed::nothing : typed(); key != Typed::nothing)
            return key == Typed::enter;
        for (auto& one : all)
            if (auto read = look(one); !read)
                return std::unexpected(read.error());
        if (live)
            show_table(all, std::exchange(first, false));
    }
    return true;
}

void print_limits(const Words& words, const std::vector<Turned>& all)
{
    Json out = Json::array();
    for (const auto& one : all) {
        const auto [low, high] = limits(one);
        const auto& device = one.driven.device;
        if (words.json())
            out.add(Json::object({{"name", device.name},
                                  {"zero_rad", one.middle_rad},
                                  {"position_min_rad", low},
                                  {"position_max_rad", high}}));
        else
            fmt::print("[joint.{}]\nzero_deg = {:.2f}\nposition_min_deg = {:.2f}\nposition_max_deg = {:.2f}\n\n",
                       device.joint != nullptr ? device.name : "NAME", units::deg(one.middle_rad),
                       units::deg(low) + 0.0, units::deg(high) + 0.0);
    }
    if (words.json())
        print(out);
}

/// A line of stdin: Enter on a terminal. False where the input has ended.
bool wait_for_enter(std::string_view request)
{
    fmt::print(stderr, "{} ", request);
    const auto what = wait_for_line();
    if (!stdin_is_terminal() || what != Typed::enter)
        fmt::print(stderr, "\n");
    return what == Typed::enter;
}

int give_up()
{
    if (interrupted())
        return exit_interrupted;
    fmt::print(stderr, "The input ended before Enter was pressed: nothing was found. The joints stay released.\n");
    return exit_refused;
}

Outcome run(const Words& words)
{
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    auto devices = targets(words);
    if (!devices)
        return std::unexpected(devices.error());
    std::vector<std::string> names;
    for (const auto& device : *devices)
        names.push_back(device.name);
    const auto yes = confirm(words, fmt::format("{} will be released: what {} carries falls", fmt::join(names, ", "),
                                                names.size() == 1 ? "it" : "they"));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    Session session;
    auto all = open_released(session, std::move(*devices));
    if (!all)
        return std::unexpected(all.error());
    if (!wait_for_enter("Turn every joint to its middle position, and press Enter.") || interrupted())
        return give_up();
    if (auto taken = take_middle(*all); !taken)
        return std::unexpected(taken.error());
    if (!*time)
        fmt::print(stderr, "Turn every joint to both of its ends, and press Enter.\n");
    const auto watched = watch_hands(session, *all, *time);
    if (!watched)
        return std::unexpected(watched.error());
    if (!*watched || interrupted())
        return give_up();
    print_limits(words, *all);
    return exit_done;
}

} // namespace

Verb calibrate_verb()
{
    return {
        .name = "calibrate",
        .says = "Find zero and limits of joints that are turned by hand, and print them for the robot file.",
        .arguments = {{"TARGET", "a joint, or a link with --family and --id; without it all joints of --robot", false}},
        .options = with_device_options(
            {{"--for", "TIME", "look for this time instead of until Enter, such as 20s"}, yes_option, json_option}),
        .examples = {{"sinew calibrate elbow --robot arm.toml", "one joint; asks first"},
                     {"sinew calibrate --robot arm.toml", "all of them at once"},
                     {"sinew calibrate elbow --robot arm.toml --sim --for 2s --yes", "a simulated one"}},
        .run = run,
        .acts = true,
        .more = "The joints are released and stay so. The middle becomes zero; the ends are counted from there, in the "
                "direction of the joint. Nothing is stored in a device: copy the lines into the robot file, a little "
                "inside of the stops."};
}

} // namespace sinew::cli
