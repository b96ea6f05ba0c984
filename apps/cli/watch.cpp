#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <utility>

namespace sinew::cli {
namespace {

constexpr Duration default_period = std::chrono::milliseconds(200);

/// One device of the table, with what went wrong with it last.
struct Watched {
    Driven driven;
    std::string trouble;
    bool lost = false; ///< it is the link that is in trouble
};

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
}

std::string_view no_state(const Watched& watched)
{
    return watched.lost ? "link lost" : "no answer";
}

std::string table(const std::vector<Watched>& all, std::size_t cells_shown)
{
    const auto some = [&](const std::vector<std::string>& cells) {
        return std::span(cells).first(std::min(cells_shown, cells.size()));
    };
    std::vector<std::string> head{"JOINT"};
    std::ranges::copy(some(state_head), std::back_inserter(head));
    Table out(head);
    for (const auto& one : all) {
        std::vector<std::string> row{one.driven.device.name};
        std::ranges::copy(some(state_cells(one.driven)), std::back_inserter(row));
        if (!one.trouble.empty())
            row[1] = no_state(one);
        out.add(std::move(row));
    }
    return out.text();
}

std::size_t longest_line(std::string_view text)
{
    std::size_t longest = 0;
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        longest = std::max(longest, width(text.substr(0, end)));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return longest;
}

/// With as many columns as fit, for a line that the terminal breaks would spoil the picture.
std::string table_that_fits(const std::vector<Watched>& all)
{
    for (std::size_t cells = state_head.size(); cells > 1; --cells) {
        const auto text = table(all, cells);
        // A row that was wrapped or stacked is one that does not fit.
        const auto lines = std::ranges::count(text, '\n');
        const bool fits = lines == static_cast<std::ptrdiff_t>(all.size()) + 1 && longest_line(text) <= columns();
        if (fits)
            return text;
    }
    return table(all, 1);
}

void print_plain(const std::vector<Watched>& all, Duration time)
{
    for (const auto& one : all) {
        std::string line = fmt::format("{:8.2f} s  {}", seconds(time), one.driven.device.name);
        for (const auto& cell : state_cells(one.driven))
            if (!cell.empty())
                line += "  " + cell;
        fmt::print("{}{}{}\n", line, one.trouble.empty() ? "" : "  ", one.trouble.empty() ? "" : no_state(one));
    }
    std::fflush(stdout);
}

void print_json(const std::vector<Watched>& all, Duration time)
{
    for (const auto& one : all) {
        Json line = state_json(one.driven, time);
        if (!one.trouble.empty())
            line.set("error", one.trouble);
        print_line(line);
    }
}

/// Over the table before, on a terminal.
void print_table(const std::vector<Watched>& all, bool first)
{
    const auto text = table_that_fits(all);
    if (!first)
        fmt::print("\033[{}A", std::ranges::count(text, '\n'));
    std::string cleared;
    for (const char c : text)
        cleared += c == '\n' ? std::string("\033[K\n") : std::string(1, c);
    fmt::print("{}", cleared);
    std::fflush(stdout);
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
    for (bool first = true; !interrupted(); first = false) {
        for (auto& one : *all)
            if (!interrupted())
                look(one);
        if (interrupted())
            break;
        // What was said stands above the table, which begins anew.
        first = news.tell(session) || first;
        const Duration since = session.clock().now() - begin;
        if (words.json())
            print_json(*all, since);
        else if (stdout_is_terminal())
            print_table(*all, first);
        else
            print_plain(*all, since);
        // A slow wire skips looks instead of falling behind.
        next = std::max(next + period->value_or(default_period), session.clock().now());
        if (next >= end)
            break;
        wait_until(session, next);
    }
    const bool silent = std::ranges::any_of(*all, [](const auto& one) { return !one.trouble.empty(); });
    for (const auto& one : *all)
        if (!one.trouble.empty() && !interrupted())
            fmt::print(stderr, "sinew: {}\n", one.trouble);
    return silent && !interrupted() ? exit_no_answer : exit_done;
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
                     {"sinew watch serial:/dev/ttyUSB0 --family sam --id 1 --json --for 5s", "for a program"}},
        .run = run,
        .more = "On a terminal the table stays in place; elsewhere every look is a line. A link that is unplugged is "
                "waited "
                "for."};
}

} // namespace sinew::cli
