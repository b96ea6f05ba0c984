#include "apps/cli/terminal.hpp"

#include "apps/cli/interrupt.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

constexpr std::size_t gap = 2;
constexpr std::size_t narrowest_text = 16; // a last column with less than this cannot be read

std::string_view environment(const char* name)
{
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
}

} // namespace

bool stdout_is_terminal()
{
    return ::isatty(STDOUT_FILENO) != 0;
}
bool stderr_is_terminal()
{
    return ::isatty(STDERR_FILENO) != 0;
}
bool stdin_is_terminal()
{
    return ::isatty(STDIN_FILENO) != 0;
}

Typed typed()
{
    while (!interrupted()) { // what never ends may have no line either
        pollfd in{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&in, 1, 0) <= 0)
            return Typed::nothing;
        char one = 0;
        if (::read(STDIN_FILENO, &one, 1) <= 0)
            return Typed::end;
        if (one == '\n' || one == '\r')
            return Typed::enter;
    }
    return Typed::nothing;
}

Typed wait_for_line()
{
    while (wait_for_input(STDIN_FILENO))
        if (const auto what = typed(); what != Typed::nothing)
            return what;
    return Typed::end;
}

std::size_t columns()
{
    constexpr std::size_t least = 20;
    winsize size{};
    if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return std::max<std::size_t>(least, size.ws_col);
    const auto text = environment("COLUMNS");
    std::size_t value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    return problem == std::errc{} && end == text.data() + text.size() ? std::max(least, value) : 80;
}

std::string bold(std::string_view text)
{
    const bool plain = !stdout_is_terminal() || !environment("NO_COLOR").empty() || environment("TERM") == "dumb";
    return plain ? std::string(text) : fmt::format("\033[1m{}\033[0m", text);
}

std::size_t width(std::string_view text)
{
    return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string wrap(std::string_view text, std::size_t indent, std::size_t fits)
{
    const std::size_t room = fits > indent + narrowest_text ? fits - indent : narrowest_text;
    std::string out;
    std::size_t used = 0;
    while (!text.empty()) {
        const auto end = std::min(text.find(' '), text.size());
        const auto word = text.substr(0, end);
        if (used > 0 && used + 1 + width(word) > room) {
            out += '\n' + std::string(indent, ' ');
            used = 0;
        }
        out += fmt::format("{}{}", used > 0 ? " " : "", word);
        used += (used > 0 ? 1 : 0) + width(word);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

void progress(std::string_view text)
{
    if (stderr_is_terminal())
        fmt::print(stderr, "\r\033[K{}", text.substr(0, columns() - 1));
}

void end_progress()
{
    progress("");
    std::fflush(stderr);
}

std::vector<std::size_t> Table::shown_columns() const
{
    std::vector<std::size_t> out;
    for (std::size_t c = 0; c < rows_.front().size(); ++c)
        if (std::any_of(rows_.begin() + 1, rows_.end(), [&](const auto& row) { return !row[c].empty(); }))
            out.push_back(c);
    return out;
}

std::string Table::stacked(std::size_t indent, std::span<const std::size_t> shown) const
{
    std::string out;
    for (std::size_t r = 1; r < rows_.size(); ++r) {
        std::string line;
        for (const auto c : shown)
            if (!rows_[r][c].empty())
                line += (line.empty() ? "" : c == shown[1] ? ": " : "; ") + rows_[r][c];
        out += std::string(indent, ' ') + wrap(line, indent + gap, columns()) + '\n';
    }
    return out;
}

std::string Table::text(std::size_t indent) const
{
    const auto shown = shown_columns();
    std::vector<std::size_t> widths(rows_.front().size());
    std::size_t before_last = indent;
    for (const auto c : shown) {
        for (const auto& row : rows_)
            widths[c] = std::max(widths[c], width(row[c]));
        if (c != shown.back())
            before_last += widths[c] + gap;
    }
    const bool last_fits = shown.empty() || before_last + std::min(widths[shown.back()], narrowest_text) <= columns();
    if (!last_fits)
        return stacked(indent, shown);
    std::string out;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        std::string line(indent, ' ');
        for (const auto c : shown) {
            const std::string& cell = rows_[r][c];
            line += c == shown.back() ? wrap(cell, before_last, columns())
                                      : cell + std::string(widths[c] - width(cell) + gap, ' ');
        }
        line.erase(line.find_last_not_of(' ') + 1);
        out += (r == 0 ? bold(line) : line) + '\n';
    }
    return out;
}

} // namespace sinew::cli
