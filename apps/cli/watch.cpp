#include "apps/cli/watch_picture.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace sinew::cli {
namespace {

constexpr Duration default_period = std::chrono::milliseconds(200);

/// Says on stderr, once each, when a link was lost and when it is back.
class LinkNews
{
public:
    /// Whether there was any.
    bool tell(const Session& session)
    {
        bool any = false;
        for (auto* bus : session.buses()) {
            const auto uri = link::parse_uri(bus->name());
            const std::string device = uri ? uri->target : bus->name();
            Known& known = known_[bus];
            if (std::exchange(known.losses, bus->losses()) != bus->losses()) {
                fmt::print(stderr, "sinew: link lost, waiting for {}\n", device);
                known.waiting = any = true;
            }
            if (known.waiting && bus->link_trouble() == nullptr) {
                fmt::print(stderr, "sinew: {} is back\n", device);
                known.waiting = false;
                any = true;
            }
        }
        return any;
    }

private:
    struct Known {
        std::uint64_t losses = 0;
        bool waiting = false;
    };
    std::map<const bus::Bus*, Known> known_;
};

std::expected<std::vector<Watched>, Error> open_all(Session& session, const Words& words)
{
    std::vector<Device> devices;
    if (words.has("TARGET")) {
        auto one = target(words);
        if (!one)
            return std::unexpected(one.error());
        devices.push_back(std::move(*one));
    } else {
        auto all = whole_robot(words);
        if (!all)
            return std::unexpected(all.error());
        devices = std::move(*all);
    }
    std::vector<Watched> out;
    for (auto& device : devices) {
        auto driven = drive(session, std::move(device));
        if (!driven)
            return std::unexpected(driven.error());
        out.push_back({.driven = std::move(*driven)});
    }
    return out;
}

void look(Watched& watched)
{
    watched.trouble.clear();
    if (auto read = read_state(watched.driven, actuator::Depth::full); !read) {
        watched.driven.state = {};
        watched.trouble = to_sentence(read.error());
        watched.lost = read.error().code == Errc::link_lost;
    }
    if (const auto position = watched.driven.state.position_rad.optional())
        watched.trend.push_back(to_joint_position(watched.driven.device.joint, *position));
    if (watched.trend.size() > longest_trend)
        watched.trend.erase(watched.trend.begin());
}

void print_plain(const Session& session, const LinkReports& reports, const std::vector<Watched>& all, Duration time)
{
    for (const auto& one : all) {
        std::string line = fmt::format("{:8.2f} s  {}", seconds(time), one.driven.device.name);
        for (const auto& cell : state_cells(one.driven))
            if (!cell.empty())
                line += "  " + cell;
        fmt::print("{}{}{}\n", line, one.trouble.empty() ? "" : "  ", one.trouble.empty() ? "" : no_state(one));
    }
    for (const auto* bus : session.buses()) {
        const auto* report = reports.of(*bus);
        if (const auto troubles = report != nullptr ? troubles_of(*report) : ""; !troubles.empty())
            fmt::print("{:8.2f} s  {}: {}\n", seconds(time), name_of(*bus, all), troubles);
    }
    std::fflush(stdout);
}

void print_json(const LinkReports& reports, const std::vector<Watched>& all, Duration time)
{
    for (const auto& one : all) {
        Json line = state_json(one.driven, time);
        if (!one.trouble.empty())
            line.set("error", one.trouble);
        if (const auto* report = reports.of(*one.driven.bus); report != nullptr)
            line.set("adapter", report_json(*report));
        print_line(line);
    }
}

Outcome run(const Words& words)
{
    const auto period = words.period("--rate");
    if (!period)
        return std::unexpected(period.error());
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    Session session;
    auto all = open_all(session, words);
    if (!all)
        return std::unexpected(all.error());
    const TimePoint begin = session.clock().now();
    const TimePoint end = *time ? begin + **time : TimePoint::max();
    TimePoint next = begin;
    LinkNews news;
    LinkReports reports;
    std::ptrdiff_t above = 0;
    bool over = false; // a recording
    const bool recorded = record::is_replay(all->front().driven.device.link);
    for (bool first = true; !interrupted(); first = false) {
        for (auto& one : *all)
            if (!interrupted())
                look(one);
        over = recorded && !first && std::ranges::none_of(*all, [](const auto& one) { return one.trouble.empty(); });
        if (interrupted() || over)
            break;
        // What was said stands above the table, which begins anew.
        if (news.tell(session))
            above = 0;
        reports.look(session);
        const Duration since = session.clock().now() - begin;
        if (words.json())
            print_json(reports, *all, since);
        else if (stdout_is_terminal())
            print_picture(session, reports, *all, above);
        else
            print_plain(session, reports, *all, since);
        // A slow wire skips looks instead of falling behind.
        next = std::max(next + period->value_or(default_period), session.clock().now());
        if (next >= end)
            break;
        wait_until(session, next);
    }
    const bool silent = std::ranges::any_of(*all, [](const auto& one) { return !one.trouble.empty(); });
    for (const auto& one : *all)
        if (!one.trouble.empty() && !interrupted() && !over)
            fmt::print(stderr, "sinew: {}\n", one.trouble);
    return silent && !interrupted() && !over ? exit_no_answer : exit_done;
}

} // namespace

Verb watch_verb()
{
    return {
        .name = "watch",
        .says = "Show the state of a device or of a whole robot until Ctrl-C.",
        .arguments = {{"TARGET", "a joint, or a link with --family and --id; without it all joints of --robot", false}},
        .options = with_device_options({{"--rate", "HZ", "looks per second; 5 where it is not given"},
                                        {"--for", "TIME", "end after this time, such as 5s"},
                                        {"--json", "", "print one object per device, look and line"}}),
        .examples = {{"sinew watch --robot arm.toml", "all joints"},
                     {"sinew watch --robot arm.toml --sim --for 2s", "simulated"},
                     {"sinew watch serial:/dev/ttyUSB0 --family sam --id 1 --json --for 5s", "for a program"}},
        .run = run,
        .more = "On a terminal the table stays in place, with the trend of each position and, below, what each bus has "
                "asked and lost; what does not fit is left out. Elsewhere every look is a line. What a CAN adapter or "
                "controller refused and lost, and its state where it is not error-active, stand in a line of its bus. "
                "A link that is unplugged is waited for. A recording ends where it has no more to tell."};
}

} // namespace sinew::cli
