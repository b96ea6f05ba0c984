#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

constexpr std::size_t gap = 2;
constexpr std::size_t narrowest_text = 16; // a last column with less than this is not wrapped but runs on

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

std::string Table::text(std::size_t indent) const
{
    std::vector<std::size_t> widths(rows_.front().size());
    std::vector<bool> shown(widths.size());
    for (std::size_t r = 0; r < rows_.size(); ++r)
        for (std::size_t c = 0; c < widths.size(); ++c) {
            widths[c] = std::max(widths[c], width(rows_[r][c]));
            shown[c] = shown[c] || (r > 0 && !rows_[r][c].empty());
        }
    const auto last_shown = std::ranges::find(shown.rbegin(), shown.rend(), true);
    const auto last = static_cast<std::size_t>(shown.rend() - last_shown) - 1;
    std::string out;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        std::string line(indent, ' ');
        std::size_t at = indent;
        for (std::size_t c = 0; c < widths.size() && last_shown != shown.rend(); ++c) {
            if (!shown[c])
                continue;
            const std::string& cell = rows_[r][c];
            if (c == last) {
                const bool runs_on = at + narrowest_text > columns();
                line += runs_on ? '\n' + std::string(indent + gap, ' ') + wrap(cell, indent + gap, columns())
                                : wrap(cell, at, columns());
                break;
            }
            line += cell + std::string(widths[c] - width(cell) + gap, ' ');
            at += widths[c] + gap;
        }
        line.erase(line.find_last_not_of(' ') + 1);
        out += (r == 0 ? bold(line) : line) + '\n';
    }
    return out;
}

} // namespace sinew::cli
