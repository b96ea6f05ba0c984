#include "sinew/record/candump.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <utility>

namespace sinew::record {
namespace {

constexpr std::uint32_t error_flag = 0x2000'0000; // CAN_ERR_FLAG of linux/can.h
constexpr std::uint32_t highest_standard = 0x7FF;
constexpr std::uint32_t highest_extended = 0x1FFF'FFFF;
constexpr std::size_t standard_digits = 3, extended_digits = 8;
constexpr std::size_t most_data = 8;
constexpr std::string_view blanks = " \t\r";

/// The word as it can stand in a sentence: of one line, and not too long.
std::string quoted(std::string_view word)
{
    constexpr std::size_t longest = 40;
    std::string out(word.substr(0, longest));
    for (char& c : out)
        c = c < ' ' || c > '~' ? '?' : c;
    return fmt::format("'{}{}'", out, word.size() > longest ? "..." : "");
}

template <class T>
std::optional<T> whole(std::string_view digits, int base)
{
    T value{};
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value, base);
    return problem == std::errc{} && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
}

std::expected<void, Error> set_identifier(std::string_view word, Captured& out)
{
    const auto id = whole<std::uint32_t>(word, 16);
    if (!id || word.size() > extended_digits)
        return fail(Errc::bad_hex, fmt::format("{} is no CAN identifier in hex", quoted(word)));
    if ((*id & error_flag) != 0 && word.size() == extended_digits) {
        out.kind = Captured::Kind::can_error;
        out.frame.can_id = *id & ~error_flag;
    } else {
        out.extended = word.size() == extended_digits || *id > highest_standard;
        out.frame.can_id = *id;
    }
    if (out.frame.can_id > highest_extended)
        return fail(Errc::bad_hex, fmt::format("{} is more than a CAN identifier can be", quoted(word)));
    return {};
}

std::expected<void, Error> set_data(std::string_view data, Captured& out)
{
    std::string plain(data);
    std::erase(plain, '.');
    const auto bytes = plain.empty() ? std::expected<std::vector<std::uint8_t>, Error>{} : from_hex(plain);
    if (!bytes)
        return std::unexpected(bytes.error());
    if (bytes->size() > most_data)
        return fail(Errc::bad_hex, fmt::format("{} bytes; a CAN frame has 8 at most", bytes->size()));
    out.frame.size = static_cast<std::uint8_t>(bytes->size());
    std::ranges::copy(*bytes, out.frame.data.begin());
    return {};
}

/// "(1436509052.249713)" with one to nine digits behind the point.
std::optional<Time> time_of(std::string_view word)
{
    if (word.size() < 2 || word.front() != '(' || word.back() != ')')
        return std::nullopt;
    word = word.substr(1, word.size() - 2);
    const auto point = std::min(word.find('.'), word.size());
    const auto fraction = word.substr(std::min(point + 1, word.size()));
    constexpr std::size_t nanosecond_digits = 9;
    constexpr std::uint64_t last_second = 9'000'000'000; // of what fits into 64 bits of nanoseconds
    const auto second = whole<std::uint64_t>(word.substr(0, point), 10);
    if (!second || *second > last_second || (point != word.size() && fraction.empty()) ||
        fraction.size() > nanosecond_digits)
        return std::nullopt;
    std::string padded(fraction);
    padded.resize(nanosecond_digits, '0');
    const auto nanoseconds = whole<std::uint32_t>(padded, 10);
    if (!nanoseconds)
        return std::nullopt;
    return Time{std::chrono::seconds(*second) + Duration{*nanoseconds}};
}

std::expected<Captured, Error> parse_line(std::string_view line)
{
    std::array<std::string_view, 4> words;
    std::size_t count = 0;
    for (std::size_t at = 0; (at = line.find_first_not_of(blanks, at)) != std::string_view::npos;) {
        const auto end = std::min(line.find_first_of(blanks, at), line.size());
        if (count == words.size())
            return fail(Errc::bad_file, fmt::format("{} follows the frame", quoted(line.substr(at, end - at))));
        words[count++] = line.substr(at, end - at);
        at = end;
    }
    const auto at = time_of(words[0]);
    if (!at)
        return fail(
            Errc::bad_file,
            fmt::format("{} is no time such as (1436509052.249713); is this a log of candump -L?", quoted(words[0])));
    if (count < 3)
        return fail(Errc::bad_file, "a line has a time, a bus and a frame");
    auto captured = parse_can(words[2]);
    if (!captured)
        return fail(Errc::bad_file, captured.error().detail);
    captured->at = *at;
    captured->bus = words[1];
    if (words[3] == "T")
        captured->direction = wire::Direction::request;
    else if (words[3] == "R")
        captured->direction = wire::Direction::reply;
    else if (!words[3].empty())
        return fail(Errc::bad_file, fmt::format("{} is neither R nor T", quoted(words[3])));
    return captured;
}

} // namespace

std::expected<Captured, Error> parse_can(std::string_view word)
{
    const auto hash = word.find('#');
    if (hash == std::string_view::npos)
        return fail(Errc::bad_hex, fmt::format("{} is no CAN frame such as 141#9A00000000000000", quoted(word)));
    Captured out{.kind = Captured::Kind::can};
    if (auto set = set_identifier(word.substr(0, hash), out); !set)
        return std::unexpected(set.error());
    const auto data = word.substr(hash + 1);
    if (data.starts_with('#'))
        return fail(Errc::bad_hex, fmt::format("{} is a CAN FD frame; no family uses those", quoted(word)));
    if (!data.starts_with('R') && !data.starts_with('r')) {
        if (auto set = set_data(data, out); !set)
            return std::unexpected(set.error());
        return out;
    }
    const auto length = data.size() == 1 ? std::optional<unsigned>(0) : whole<unsigned>(data.substr(1), 10);
    if (!length || *length > most_data || out.kind == Captured::Kind::can_error)
        return fail(Errc::bad_hex, fmt::format("{} is no remote request such as 141#R8", quoted(word)));
    out.kind = Captured::Kind::can_remote;
    out.frame.size = static_cast<std::uint8_t>(*length);
    return out;
}

std::string can_text(const Captured& captured)
{
    const auto& frame = captured.frame;
    const bool is_error = captured.kind == Captured::Kind::can_error;
    const bool is_long = is_error || captured.extended || frame.can_id > highest_standard;
    std::string out = fmt::format("{:0{}X}#", frame.can_id | (is_error ? error_flag : 0),
                                  is_long ? extended_digits : standard_digits);
    if (captured.kind == Captured::Kind::can_remote)
        return out + (frame.size == 0 ? "R" : fmt::format("R{}", frame.size));
    for (const std::uint8_t byte : frame.bytes())
        out += fmt::format("{:02X}", byte);
    return out;
}

void CandumpReader::feed(std::span<const std::uint8_t> bytes)
{
    text_.erase(0, std::exchange(at_, 0));
    text_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

std::optional<std::string_view> CandumpReader::next_line()
{
    const auto end = text_.find('\n', at_);
    if (end == std::string::npos)
        return std::nullopt;
    const auto line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + 1;
    return line;
}

std::expected<std::optional<Captured>, Error> CandumpReader::next()
{
    const auto here = [&](std::string_view what) {
        return fail(Errc::bad_file, fmt::format("line {}: {}", line_, what));
    };
    while (const auto line = next_line()) {
        if (std::exchange(skipping_, false))
            continue;
        ++line_;
        const auto first = line->find_first_not_of(blanks);
        if (first == std::string_view::npos || (*line)[first] == '#' || (*line)[first] == ';')
            continue;
        if (line->size() > longest_line)
            return here("it is too long for a log of candump");
        auto captured = parse_line(*line);
        if (!captured)
            return here(captured.error().detail);
        return *std::move(captured);
    }
    const std::size_t left = text_.size() - at_;
    if (skipping_ || left > longest_line) {
        text_.clear();
        at_ = 0;
        if (std::exchange(skipping_, true))
            return std::nullopt;
        ++line_;
        return here("it is too long for a log of candump");
    }
    if (!ended_ || left == 0)
        return std::nullopt;
    const bool is_blank = std::string_view(text_).find_first_not_of(blanks, at_) == std::string_view::npos;
    text_.clear();
    at_ = 0;
    if (is_blank)
        return std::nullopt;
    ++line_;
    return here("the file ends inside this line; all before it was read");
}

std::expected<void, Error> CandumpWriter::add(const Captured& captured, std::string& out)
{
    if (!captured.is_can())
        return fail(Errc::bad_argument, "a log of candump holds CAN frames only; for a serial line write a .pcapng");
    const auto since = captured.at.time_since_epoch();
    if (since < Duration{})
        return fail(Errc::bad_argument, "a log of candump holds no time before 1970");
    std::string bus = captured.bus.empty() ? "can" : captured.bus;
    for (char& c : bus)
        c = c <= ' ' || c > '~' ? '_' : c; // a blank would end the word
    const auto second = std::chrono::floor<std::chrono::seconds>(since);
    const auto micros = std::chrono::floor<std::chrono::microseconds>(since - second);
    out += fmt::format("({}.{:06}) {} {}", second.count(), micros.count(), bus, can_text(captured));
    if (captured.direction)
        out += *captured.direction == wire::Direction::request ? " T" : " R";
    out += '\n';
    return {};
}

} // namespace sinew::record
