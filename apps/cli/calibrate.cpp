#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/terminal.hpp"
#include "apps/cli/watch_picture.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

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

/// What rounds to zero has no sign.
std::string in_deg(double rad, int decimals = 2)
{
    const double deg = units::deg(rad);
    return fmt::format("{:.{}f}", std::abs(deg) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : deg, decimals);
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

void say_who_is_limp(std::span<const Turned> told)
{
    std::vector<std::string_view> names;
    for (const auto& one : told)
        names.push_back(one.driven.device.name);
    if (!names.empty())
        fmt::print(stderr, "sinew: {} {} told to let go and may be limp\n", fmt::join(names, ", "),
                   names.size() == 1 ? "was" : "were");
}

/// Asks all of them where they are before the first lets go.
std::expected<std::vector<Turned>, Error> open_released(Session& session, std::vector<Device> devices)
{
    std::vector<Turned> all;
    for (auto& device : devices) {
        auto driven = drive(session, std::move(device));
        if (!driven)
            return std::unexpected(driven.error());
        all.push_back({.driven = std::move(*driven)});
        if (auto read = look(all.back()); !read)
            return std::unexpected(read.error());
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        const auto requests = all[i].driven.driver->plan({.mode = actuator::Mode::release}, {});
        const auto sent = requests ? carry_out(all[i].driven, *requests) : std::unexpected(requests.error());
        if (!sent) {
            say_who_is_limp(std::span(all).first(i + 1));
            return std::unexpected(sent.error());
        }
    }
    return all;
}

/// What a hand and an encoder do without anybody turning the joint.
constexpr double least_turn_rad = units::rad(0.5);

bool was_turned(const Turned& one)
{
    const auto [low, high] = limits(one);
    return high - low >= least_turn_rad;
}

/// A line for each joint that the window has room for; the terminal breaks none.
std::string picture(std::span<const Turned> all, const Window& window)
{
    const bool narrow = window.columns < 44;
    const std::size_t gap = narrow ? 1 : 2, number = narrow ? 6 : 8, numbers = 3 * (gap + number);
    std::size_t longest = 0;
    for (const auto& one : all)
        longest = std::max(longest, one.driven.device.name.size());
    const auto name =
        std::max<std::size_t>(4, std::min(longest, window.columns - std::min(window.columns, numbers + 1)));
    const auto line = [&](std::string_view first, std::span<const std::string> cells) {
        std::string out = fmt::format("{:{}}", first.substr(0, name), name);
        for (const auto& cell : cells)
            out += fmt::format("{:>{}}", cell, gap + number);
        return out.substr(0, window.columns) + '\n';
    };
    std::string out = line("NAME", std::array<std::string, 3>{"MIN", "POS", "MAX"});
    const std::size_t room = std::max<std::size_t>(window.rows, 5) - 3; // head, rest and cursor
    const auto shown = all.size() <= room + 1 ? all : all.first(room);
    for (const auto& one : shown) {
        const auto [low, high] = limits(one);
        const double at = to_joint_velocity(one.driven.device.joint, one.at_rad - one.middle_rad);
        const auto deg = [&](double rad) { return in_deg(rad, narrow ? 1 : 2); };
        out += line(one.driven.device.name, std::array{deg(low), deg(at), deg(high)});
    }
    if (shown.size() < all.size())
        out += fmt::format("and {} more", all.size() - shown.size()).substr(0, window.columns) + '\n';
    return out;
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
    std::ptrdiff_t above = 0;
    for (TimePoint next = begin; next < end && !interrupted(); next += period) {
        wait_until(session, next);
        if (const auto key = time ? Typed::nothing : typed(); key != Typed::nothing)
            return key == Typed::enter;
        for (auto& one : all)
            if (auto read = look(one); !read)
                return std::unexpected(read.error());
        if (live)
            print_over(stderr, picture(all, window_of(STDERR_FILENO)), above);
    }
    return true;
}

void print_limits(const Words& words, const std::vector<Turned>& all)
{
    Json out = Json::array();
    for (const auto& one : all) {
        const auto [low, high] = limits(one);
        const auto& device = one.driven.device;
        const bool turned = was_turned(one);
        if (words.json())
            out.add(Json::object({{"name", device.name},
                                  {"zero_rad", one.middle_rad},
                                  {"position_min_rad", turned ? Json(low) : Json()},
                                  {"position_max_rad", turned ? Json(high) : Json()}}));
        else
            fmt::print("[joint.{}]\nzero_deg = {}\n{}\n", device.joint != nullptr ? device.name : "NAME",
                       in_deg(one.middle_rad),
                       turned ? fmt::format("position_min_deg = {}\nposition_max_deg = {}\n", in_deg(low), in_deg(high))
                              : std::string{});
        if (!turned)
            fmt::print(stderr, "sinew: nobody turned {}, so it gets no limits\n", device.name);
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
    if (auto taken = take_middle(*all); !taken) {
        say_who_is_limp(*all);
        return std::unexpected(taken.error());
    }
    if (!*time)
        fmt::print(stderr, "Turn every joint to both of its ends, and press Enter.\n");
    const auto watched = watch_hands(session, *all, *time);
    if (!watched) {
        say_who_is_limp(*all);
        return std::unexpected(watched.error());
    }
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
