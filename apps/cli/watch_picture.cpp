#include "apps/cli/watch_picture.hpp"

#include "apps/cli/bus_target.hpp"
#include "apps/cli/plot.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

/// The first cells of each state and, if there is room, how the position went on.
std::string table(std::span<const Watched> all, std::size_t cells_shown, std::size_t trend = 0)
{
    const auto some = [&](const std::vector<std::string>& cells) {
        return std::span(cells).first(std::min(cells_shown, cells.size()));
    };
    std::vector<std::string> head{"JOINT"};
    std::ranges::copy(some(state_head), std::back_inserter(head));
    if (trend > 0)
        head.insert(head.begin() + 2, "TREND");
    Table out(head);
    for (const auto& one : all) {
        std::vector<std::string> row{one.driven.device.name};
        std::ranges::copy(some(state_cells(one.driven)), std::back_inserter(row));
        if (!one.trouble.empty())
            row[1] = no_state(one);
        if (trend > 0) {
            const auto line = sparkline(one.trend, trend);
            row.insert(row.begin() + 2, line + std::string(trend - width(line), ' '));
        }
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

bool fits(std::string_view text, std::size_t rows)
{
    // A row that was wrapped or stacked is one that does not fit.
    return std::ranges::count(text, '\n') == static_cast<std::ptrdiff_t>(rows) + 1 && longest_line(text) <= columns();
}

/// With as many columns as fit, for a line that the terminal breaks would spoil the picture.
std::string table_that_fits(std::span<const Watched> all)
{
    for (const std::size_t trend : {longest_trend, longest_trend / 2})
        if (auto text = table(all, state_head.size(), trend); fits(text, all.size()))
            return text;
    for (std::size_t cells = state_head.size(); cells > 1; --cells)
        if (auto text = table(all, cells); fits(text, all.size()))
            return text;
    return table(all, 1);
}

std::size_t screen_rows()
{
    constexpr std::size_t unknown = 1000; // all of them
    winsize size{};
    return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 4 ? size.ws_row : unknown;
}

/// A line for each bus: how its wire is.
std::string bus_lines(const Session& session)
{
    std::string out;
    for (const auto* bus : session.buses()) {
        const auto& seen = bus->conversation().counters();
        std::string line = fmt::format("{}: {} asked, {} lost", short_name(bus->name()), seen.requests, seen.timeouts);
        const auto add = [&](std::uint64_t count, std::string_view what) {
            if (count > 0)
                line += fmt::format(", {} {}", count, what);
        };
        add(seen.late, "late");
        add(seen.strays, "strays");
        add(seen.bad_checksums, "bad checksums");
        add(seen.retries, "asked again");
        if (bus->link_trouble() != nullptr)
            line += ", link lost";
        out += line.substr(0, columns()) + '\n';
    }
    return out;
}

/// What a screen shows: the joints that it has room for, and the buses.
std::string picture(const Session& session, std::span<const Watched> all)
{
    const auto buses = bus_lines(session);
    const auto below = static_cast<std::size_t>(std::ranges::count(buses, '\n')) + 3; // head, rest and cursor
    const std::size_t room = std::max<std::size_t>(screen_rows(), below + 1) - below;
    if (all.size() <= room + 1)
        return table_that_fits(all) + buses;
    return table_that_fits(all.first(room)) +
           fmt::format("and {} more; name one, or make the window higher\n", all.size() - room).substr(0, columns()) +
           buses;
}

} // namespace

std::string_view no_state(const Watched& watched)
{
    return watched.lost ? "link lost" : "no answer";
}

void print_picture(const Session& session, std::span<const Watched> all, std::ptrdiff_t& above)
{
    const auto text = picture(session, all);
    if (above > 0)
        fmt::print("\033[{}A", above);
    above = std::ranges::count(text, '\n');
    std::string cleared;
    for (const char c : text)
        cleared += c == '\n' ? std::string("\033[K\n") : std::string(1, c);
    fmt::print("{}\033[J", cleared);
    std::fflush(stdout);
}

} // namespace sinew::cli
