#include "apps/cli/capture.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/record/candump.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <optional>

namespace sinew::cli {
namespace {

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

/// 141#A200000028230000
std::expected<Captured, Error> plain_frame(std::string_view word)
{
    auto captured = record::parse_can(word);
    if (!captured)
        return captured;
    if (captured->kind == Captured::Kind::can_remote)
        return fail(Errc::bad_hex, fmt::format("'{}' is a remote request, which carries nothing", word));
    if (captured->kind == Captured::Kind::can_error)
        return fail(Errc::bad_hex, fmt::format("'{}' is an error frame, which no device has sent", word));
    if (captured->extended)
        return fail(Errc::bad_hex, fmt::format("the identifier {:X} is an extended one (29 bits); no family uses those",
                                               captured->frame.can_id));
    return captured;
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
    std::string word = fmt::format("{}#", words[at - 1]);
    for (const std::uint8_t byte : *bytes)
        word += fmt::format("{:02X}", byte);
    return plain_frame(word);
}

} // namespace

std::expected<Captured, Error> parse_capture(std::string_view line)
{
    const auto words = words_of(line);
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (length(words[i]))
            return spread(words, i);
        if (words[i].find('#') != std::string_view::npos)
            return plain_frame(words[i]);
    }
    auto bytes = from_hex(line);
    if (!bytes)
        return std::unexpected(bytes.error());
    return Captured{.bytes = *std::move(bytes)};
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
