#include "sinew/link/can_ids.hpp"

#include "sinew/link/uri.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>

namespace sinew::link {
namespace {

constexpr std::uint32_t highest_id = 0x7FF;

std::optional<std::uint32_t> identifier(std::string_view word)
{
    std::uint32_t id = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), id, 16);
    if (problem != std::errc{} || end != word.data() + word.size() || id > highest_id)
        return std::nullopt;
    return id;
}

/// The range cut into blocks whose size is a power of two and that begin at a multiple of it.
void add_range(std::uint32_t first, std::uint32_t last, std::vector<IdFilter>& into)
{
    while (first <= last) {
        std::uint32_t size = first == 0 ? highest_id + 1 : 1U << std::countr_zero(first);
        while (size > last - first + 1)
            size /= 2;
        into.push_back({.id = first, .mask = highest_id & ~(size - 1)});
        first += size;
    }
}

} // namespace

std::expected<std::vector<IdFilter>, Error> parse_can_ids(std::string_view text)
{
    std::vector<IdFilter> out;
    for (std::string_view rest = text;;) {
        const std::string_view word = rest.substr(0, rest.find(','));
        const auto dash = word.find('-');
        const auto first = identifier(word.substr(0, dash));
        const auto last = dash == std::string_view::npos ? first : identifier(word.substr(dash + 1));
        if (!first || !last || *first > *last)
            return fail(Errc::bad_uri,
                        fmt::format("option ids takes identifiers in hex from 0 to 7FF, such as ids=141-160,280; "
                                    "'{}' is none",
                                    word));
        add_range(*first, *last, out);
        if (word.size() == rest.size())
            return out;
        rest.remove_prefix(word.size() + 1);
    }
}

std::string with_can_ids(const std::string& link, std::span<const std::uint32_t> ids)
{
    auto uri = parse_uri(link);
    if (!uri || uri->scheme != "can" || uri->option("ids") || ids.empty())
        return link;
    uri->options.emplace_back("ids", fmt::format("{:X}", fmt::join(ids, ",")));
    return to_string(*uri);
}

} // namespace sinew::link
