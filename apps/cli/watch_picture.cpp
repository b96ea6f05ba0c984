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

/// What is shown of each joint: cells by their place in `state_head`, and how the position went on.
struct Layout {
    std::vector<std::size_t> cells;
    std::size_t trend = 0;
    std::size_t longest_cell = 1000; ///< what is longer is cut
};

constexpr std::size_t position = 0, speed = 1, current = 2, voltage = 3, temperature = 4, faults = 5;

/// From the widest to the narrowest: what matters least goes first.
const std::vector<Layout>& layouts()
{
    static const std::vector<Layout> all{
        {{position, speed, current, voltage, temperature, faults}, longest_trend},
        {{position, speed, current, voltage, temperature, faults}, longest_trend / 2},
        {{position, speed, current, temperature, faults}, longest_trend / 2},
        {{position, speed, temperature, faults}, longest_trend / 2},
        {{position, temperature, faults}, longest_trend / 2},
        {{position, temperature, faults}, longest_trend / 3},
        {{position, faults}, longest_trend / 2},
        {{position, faults}, longest_trend / 3},
        {{position, faults}},
        {{position, faults}, 0, 9},
        {{position}},
    };
    return all;
}

std::vector<std::string> some(const std::vector<std::string>& cells, const Layout& layout)
{
    std::vector<std::string> out;
    for (const auto c : layout.cells)
        out.push_back(cells[c].size() > layout.longest_cell && c == faults
                          ? cells[c].substr(0, layout.longest_cell - 1) + "+"
                          : cells[c]);
    return out;
}

std::string table(std::span<const Watched> all, const Layout& layout)
{
    std::vector<std::string> head{"JOINT"};
    std::ranges::copy(some(state_head, layout), std::back_inserter(head));
    if (layout.trend > 0)
        head.insert(head.begin() + 2, "TREND");
    Table out(head);
    for (const auto& one : all) {
        std::vector<std::string> row{one.driven.device.name};
        std::ranges::copy(some(state_cells(one.driven), layout), std::back_inserter(row));
        if (!one.trouble.empty())
            row[1] = no_state(one);
        if (layout.trend > 0) {
            const auto line = sparkline(one.trend, layout.trend);
            row.insert(row.begin() + 2, line + std::string(layout.trend - width(line), ' '));
        }
        out.add(std::move(row));
    }
    return out.text();
}

/// What a line takes of the screen: bold takes nothing.
std::size_t shown_width(std::string_view line)
{
    return width(line) - (line.starts_with("\033[") ? bold("").size() : 0);
}

std::size_t longest_line(std::string_view text)
{
    std::size_t longest = 0;
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        longest = std::max(longest, shown_width(text.substr(0, end)));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return longest;
}

bool fits(std::string_view text, std::size_t rows)
{
    // A row that was wrapped is one that does not fit, and rows that were stacked have no head.
    return text.substr(0, text.find('\n')).contains("JOINT") &&
           std::ranges::count(text, '\n') == static_cast<std::ptrdiff_t>(rows) + 1 && longest_line(text) <= columns();
}

/// With as many columns as fit, for a line that the terminal breaks would spoil the picture.
std::string table_that_fits(std::span<const Watched> all)
{
    for (const auto& layout : layouts())
        if (auto text = table(all, layout); fits(text, all.size()))
            return text;
    return table(all, layouts().back());
}

/// A line for each bus: how its wire is; and one for what its link tells of troubles.
std::string bus_lines(const Session& session, const LinkReports& reports, std::span<const Watched> all)
{
    std::string out;
    for (const auto* bus : session.buses()) {
        const auto& seen = bus->conversation().counters();
        std::string line = fmt::format("{}: {} asked, {} lost", name_of(*bus, all), seen.requests, seen.timeouts);
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
        const auto* report = reports.of(*bus);
        if (const auto troubles = report != nullptr ? troubles_of(*report) : ""; !troubles.empty())
            out += ("  " + troubles).substr(0, columns()) + '\n';
    }
    return out;
}

/// What a screen shows: the joints that it has room for, and the buses.
std::string picture(const Session& session, const LinkReports& reports, std::span<const Watched> all)
{
    const auto buses = bus_lines(session, reports, all);
    const auto below = static_cast<std::size_t>(std::ranges::count(buses, '\n')) + 3; // head, rest and cursor
    const std::size_t room = std::max<std::size_t>(window_of(STDOUT_FILENO).rows, below + 1) - below;
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

std::string name_of(const bus::Bus& bus, std::span<const Watched> all)
{
    for (const auto& one : all)
        if (one.driven.bus == &bus && one.driven.device.joint != nullptr)
            return one.driven.device.joint->bus.value;
    return short_name(bus.name());
}

Window window_of(int fd)
{
    winsize size{};
    Window out;
    if (::ioctl(fd, TIOCGWINSZ, &size) != 0)
        return out;
    out.columns = size.ws_col > 0 ? size.ws_col : out.columns;
    out.rows = size.ws_row > 4 ? size.ws_row : out.rows;
    return out;
}

void print_over(std::FILE* out, std::string_view text, std::ptrdiff_t& above)
{
    if (above > 0)
        fmt::print(out, "\033[{}A", above);
    above = std::ranges::count(text, '\n');
    std::string cleared;
    for (const char c : text)
        cleared += c == '\n' ? std::string("\033[K\n") : std::string(1, c);
    fmt::print(out, "{}\033[J", cleared);
    std::fflush(out);
}

void print_picture(const Session& session, const LinkReports& reports, std::span<const Watched> all,
                   std::ptrdiff_t& above)
{
    print_over(stdout, picture(session, reports, all), above);
}

} // namespace sinew::cli
