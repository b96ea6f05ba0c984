#include "apps/cli/capture.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <optional>

namespace sinew::cli {
namespace {

constexpr std::uint32_t highest_identifier = 0x7FF;
constexpr std::string_view blanks = " \t\r";

std::vector<std::string_view> words_of(std::string_view line)
{
    std::vector<std::string_view> out;
    std::size_t at = 0;
    while ((at = line.find_first_not_of(blanks, at)) != std::string_view::npos) {
        const auto end = std::min(line.find_first_of(blanks, at), line.size());
        out.push_back(line.substr(at, end - at));
        at = end;
    }
    return out;
}

std::expected<std::uint32_t, Error> identifier(std::string_view word)
{
    std::uint32_t id = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), id, 16);
    if (problem != std::errc{} || end != word.data() + word.size())
        return fail(Errc::bad_hex, fmt::format("'{}' is no CAN identifier in hex", word));
    if (id > highest_identifier)
        return fail(Errc::bad_hex,
                    fmt::format("the identifier {:X} is an extended one (29 bits); no family uses those", id));
    return id;
}

std::expected<Captured, Error> can_frame(std::string_view id_word, const std::vector<std::uint8_t>& data)
{
    const auto id = identifier(id_word);
    if (!id)
        return std::unexpected(id.error());
    if (data.size() > 8)
        return fail(Errc::bad_hex, fmt::format("{} bytes; a CAN frame has 8 at most", data.size()));
    wire::Frame frame{.can_id = *id, .size = static_cast<std::uint8_t>(data.size())};
    std::ranges::copy(data, frame.data.begin());
    return frame;
}

/// 141#A200000028230000
std::expected<Captured, Error> compact(std::string_view word)
{
    const auto hash = word.find('#');
    const auto data = word.substr(hash + 1);
    if (data.starts_with('#'))
        return fail(Errc::bad_hex, fmt::format("'{}' is a CAN FD frame; no family uses those", word));
    if (data.starts_with('R') || data.starts_with('r'))
        return fail(Errc::bad_hex, fmt::format("'{}' is a remote request, which carries nothing", word));
    if (data.empty())
        return can_frame(word.substr(0, hash), {});
    std::string plain(data);
    std::erase(plain, '.');
    const auto bytes = from_hex(plain);
    return bytes ? can_frame(word.substr(0, hash), *bytes) : std::unexpected(bytes.error());
}

/// The number in "[8]".
std::optional<std::size_t> length(std::string_view word)
{
    std::size_t value = 0;
    if (word.size() < 3 || word.front() != '[' || word.back() != ']')
        return std::nullopt;
    const auto [end, problem] = std::from_chars(word.data() + 1, word.data() + word.size() - 1, value);
    return problem == std::errc{} && end == word.data() + word.size() - 1 ? std::optional(value) : std::nullopt;
}

/// can0  141   [8]  A2 00 00 00 28 23 00 00
std::expected<Captured, Error> spread(const std::vector<std::string_view>& words, std::size_t at)
{
    const auto count = *length(words[at]);
    if (at == 0)
        return fail(Errc::bad_hex, fmt::format("no CAN identifier before {}", words[at]));
    std::string hex;
    for (const auto& word : std::span(words).subspan(at + 1).first(std::min(count, words.size() - at - 1)))
        hex += fmt::format("{} ", word);
    const auto bytes = hex.empty() ? std::expected<std::vector<std::uint8_t>, Error>{} : from_hex(hex);
    if (!bytes)
        return std::unexpected(bytes.error());
    if (bytes->size() != count)
        return fail(Errc::bad_hex, fmt::format("{} bytes follow where {} says {}", bytes->size(), words[at], count));
    return can_frame(words[at - 1], *bytes);
}

} // namespace

std::expected<Captured, Error> parse_capture(std::string_view line)
{
    const auto words = words_of(line);
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (length(words[i]))
            return spread(words, i);
        if (words[i].find('#') != std::string_view::npos)
            return compact(words[i]);
    }
    auto bytes = from_hex(line);
    if (!bytes)
        return std::unexpected(bytes.error());
    return *std::move(bytes);
}

std::vector<Line> lines_of(std::string_view text)
{
    std::vector<Line> out;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const auto end = std::min(text.find('\n'), text.size());
        auto line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const auto first = line.find_first_not_of(blanks);
        if (first == std::string_view::npos)
            continue;
        line.remove_prefix(first);
        line = line.substr(0, line.find_last_not_of(blanks) + 1);
        if (!line.starts_with('#') && !line.starts_with(';') && !line.starts_with("//"))
            out.push_back({number, line});
    }
    return out;
}

} // namespace sinew::cli
