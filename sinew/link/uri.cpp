#include "sinew/link/uri.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

namespace sinew::link {
namespace {

constexpr std::string_view form =
    "a link is written SCHEME:TARGET?OPTION=VALUE, such as serial:/dev/ttyUSB0?baud=1500000";

bool is_digits(std::string_view text)
{
    return !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

bool is_scheme(std::string_view text)
{
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !text.empty() && is_letter(text.front()) &&
           std::ranges::all_of(text, [&](char c) { return is_letter(c) || is_digits({&c, 1}); });
}

/// What somebody who left the scheme out most likely meant.
std::string without_scheme(std::string_view text)
{
    if (text.starts_with('/'))
        return fmt::format("'{0}' has no scheme: write serial:{0}", text);
    const auto colon = text.rfind(':');
    if (colon != std::string_view::npos && colon > 0 && is_digits(text.substr(colon + 1)))
        return fmt::format("'{0}' has no scheme: write tcp://{0}", text);
    return fmt::format("'{}' is no link: {}", text, form);
}

std::expected<void, Error> add_options(Uri& uri, std::string_view text)
{
    while (!text.empty()) {
        const auto end = std::min(text.find('&'), text.size());
        const std::string_view option = text.substr(0, end);
        const auto equals = option.find('=');
        if (equals == std::string_view::npos || equals == 0 || equals + 1 == option.size())
            return fail(Errc::bad_uri,
                        fmt::format("option '{}' is not written NAME=VALUE, such as baud=1500000", option));
        const std::string_view name = option.substr(0, equals);
        if (uri.option(name))
            return fail(Errc::bad_uri, fmt::format("option '{}' is given twice", name));
        uri.options.emplace_back(name, option.substr(equals + 1));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return {};
}

} // namespace

std::optional<std::string_view> Uri::option(std::string_view name) const
{
    for (const auto& [key, value] : options)
        if (key == name)
            return value;
    return std::nullopt;
}

std::expected<std::optional<std::uint32_t>, Error> Uri::number(std::string_view name) const
{
    const auto text = option(name);
    if (!text)
        return std::nullopt;
    std::uint32_t value = 0;
    const auto [end, problem] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (problem != std::errc{} || end != text->data() + text->size() || value == 0)
        return fail(Errc::bad_uri, fmt::format("option {} must be a whole positive number, not '{}'", name, *text));
    return value;
}

std::expected<Uri, Error> parse_uri(std::string_view text)
{
    const auto colon = text.find(':');
    if (colon == std::string_view::npos || !is_scheme(text.substr(0, colon)))
        return fail(Errc::bad_uri, without_scheme(text));

    Uri uri{.scheme = std::string{text.substr(0, colon)}};
    std::string_view rest = text.substr(colon + 1);
    if (uri.scheme == "tcp" && rest.starts_with("//"))
        rest.remove_prefix(2);
    const auto target_end = std::min(rest.find_first_of("?#"), rest.size());
    uri.target = rest.substr(0, target_end);
    rest.remove_prefix(target_end);
    if (uri.target.empty())
        return fail(Errc::bad_uri, fmt::format("'{}' names no target: {}", text, form));

    // The fragment stands last in every other URI, but whoever adds an option to sim:arm.toml#left appends it.
    while (!rest.empty()) {
        const char mark = rest.front();
        rest.remove_prefix(1);
        const auto end = std::min(rest.find_first_of("?#"), rest.size());
        const std::string_view part = rest.substr(0, end);
        rest.remove_prefix(end);
        if (mark == '#') {
            if (part.empty() || !uri.fragment.empty())
                return fail(Errc::bad_uri, fmt::format("'{}' must have one name after one '#'", text));
            uri.fragment = part;
        } else if (const auto added = add_options(uri, part); !added) {
            return std::unexpected(added.error());
        }
    }
    return uri;
}

std::string with_bit_rate(const std::string& link, std::uint32_t bit_rate)
{
    auto uri = parse_uri(link);
    if (!uri || (uri->scheme != "serial" && uri->scheme != "rs485") || uri->option("baud"))
        return link;
    uri->options.emplace_back("baud", std::to_string(bit_rate));
    return to_string(*uri);
}

std::string to_string(const Uri& uri)
{
    std::string text = fmt::format("{}:{}{}", uri.scheme, uri.scheme == "tcp" ? "//" : "", uri.target);
    char mark = '?';
    for (const auto& [name, value] : uri.options) {
        text += fmt::format("{}{}={}", mark, name, value);
        mark = '&';
    }
    if (!uri.fragment.empty())
        text += fmt::format("#{}", uri.fragment);
    return text;
}

} // namespace sinew::link
