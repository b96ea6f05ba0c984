#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <numeric>

namespace sinew {
namespace {

constexpr std::string_view separators = " \t\r\n,:";

int digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    if (c >= 'A' && c <= 'F')
        return c - 'A' + 10;
    return -1;
}

std::size_t distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
        }
    }
    return row[b.size()];
}

} // namespace

std::string to_hex(std::span<const std::uint8_t> bytes)
{
    std::string text;
    for (const auto byte : bytes)
        text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
    return text;
}

std::expected<std::vector<std::uint8_t>, Error> from_hex(std::string_view text)
{
    std::vector<std::uint8_t> bytes;
    std::size_t at = 0;
    while ((at = text.find_first_not_of(separators, at)) != std::string_view::npos) {
        const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
        std::string_view group = text.substr(at, end - at);
        const bool prefixed = group.starts_with("0x") || group.starts_with("0X");
        if (prefixed)
            group.remove_prefix(2);
        for (const char c : group)
            if (digit(c) < 0)
                return fail(Errc::bad_hex, fmt::format("'{}' in '{}' is no hex digit (0-9, A-F)", c, group));
        if (group.size() == 1 && prefixed) {
            bytes.push_back(static_cast<std::uint8_t>(digit(group[0])));
        } else if (group.empty() || group.size() % 2 != 0) {
            return fail(Errc::bad_hex, fmt::format("'{}' has {} hex digits; a byte takes two",
                                                   text.substr(at, end - at), group.size()));
        } else {
            for (std::size_t i = 0; i < group.size(); i += 2)
                bytes.push_back(static_cast<std::uint8_t>(digit(group[i]) * 16 + digit(group[i + 1])));
        }
        at = end;
    }
    if (bytes.empty())
        return fail(Errc::bad_hex, "no bytes given; write them in hex, such as FF A0 00 20");
    return bytes;
}

std::expected<std::int64_t, Error> to_integer(std::string_view text)
{
    std::string_view rest = text;
    const bool negative = rest.starts_with('-');
    if (negative)
        rest.remove_prefix(1);
    const bool hex = rest.starts_with("0x") || rest.starts_with("0X");
    if (hex)
        rest.remove_prefix(2);
    std::int64_t value{};
    const auto [end, problem] = std::from_chars(rest.data(), rest.data() + rest.size(), value, hex ? 16 : 10);
    if (problem != std::errc{} || end != rest.data() + rest.size() || rest.starts_with('-'))
        return fail(Errc::bad_argument, fmt::format("'{}' is not a whole number", text));
    return negative ? -value : value;
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates)
{
    std::string_view best;
    std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2) + 1;
    for (const auto candidate : candidates) {
        const std::size_t d = distance(word, candidate);
        if (d < best_distance) {
            best = candidate;
            best_distance = d;
        }
    }
    return best;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates)
{
    const auto near = nearest(word, candidates);
    return near.empty() ? std::string{} : fmt::format(", did you mean {}?", near);
}

} // namespace sinew
