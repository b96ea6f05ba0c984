#include "sinew/family/sam/motion_text.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/family/sam/models.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::sam {
namespace {

enum Instruction : std::uint8_t { none, go, special, delay, outputs, until_position, until_ad, repeat, end };

constexpr double deg_per_unit = 1.08; // of quick coordinates, the same in every model (L392)
constexpr int highest_data = 254;     // L1504
constexpr int weakest_level = 4;
constexpr int fastest_wheel = 15;
constexpr int longest_delay_ms = 4095;

constexpr std::array<std::string_view, 6> comparisons{"", "=", ">", "<", ">=", "<="};
constexpr std::string_view verbs[] = {"go", "wait", "until", "wheel", "passive", "brake", "outputs", "repeat", "end"};

using Words = std::vector<std::string_view>;
using Result = std::expected<wire::Pair, std::string>; // or what is wrong

constexpr std::uint8_t command(Instruction instruction, int sub = 0)
{
    return static_cast<std::uint8_t>(instruction << 4 | sub);
}

wire::Pair pair(std::uint8_t first, std::int64_t data)
{
    return {first, static_cast<std::uint8_t>(data)};
}

std::unexpected<std::string> wrong(std::string what)
{
    return std::unexpected(std::move(what));
}

std::optional<std::int64_t> number(std::string_view word, std::int64_t low, std::int64_t high)
{
    const auto value = to_integer(word);
    return value && *value >= low && *value <= high ? std::optional(*value) : std::nullopt;
}

/// A raw quick position, or an angle from the middle.
std::optional<std::int64_t> position(std::string_view word)
{
    if (!word.ends_with("deg"))
        return number(word, 0, highest_data);
    word.remove_suffix(3);
    double angle_deg = 0.0;
    const auto [rest, problem] = std::from_chars(word.data(), word.data() + word.size(), angle_deg);
    const double raw = boundary_centre + angle_deg / deg_per_unit;
    if (problem != std::errc{} || rest != word.data() + word.size() || !(raw >= 0.0 && raw <= highest_data))
        return std::nullopt;
    return std::lround(raw);
}

Result go_from(const Words& words)
{
    const auto target = words.size() > 1 ? position(words[1]) : std::nullopt;
    const bool has_level = words.size() == 4 && words[2] == "level";
    const auto level = has_level ? number(words[3], 0, weakest_level) : std::optional<std::int64_t>(0);
    if (!target || !level || (words.size() != 2 && !has_level))
        return wrong(
            "go takes a position from 0 to 254, or an angle such as 45deg, and may take a level: go 82 level 2");
    return pair(command(go, static_cast<int>(*level)), *target);
}

Result wait_from(const Words& words)
{
    const bool ends_well = words.size() == 2 && words[1].ends_with("ms");
    const auto time = ends_well ? number(words[1].substr(0, words[1].size() - 2), 0, longest_delay_ms) : std::nullopt;
    if (!time)
        return wrong("wait takes a time up to 4094ms, such as wait 266ms");
    if ((*time & 0xFF) > highest_data)
        return wrong(fmt::format("{} ms cannot be sent, for no byte of a program is 255; take {} or {} ms", *time,
                                 *time - 1, *time == longest_delay_ms ? *time - 1 : *time + 1));
    return pair(command(delay, static_cast<int>(*time >> 8)), *time & 0xFF);
}

Result until_from(const Words& words)
{
    const bool of_position = words.size() == 4 && words[1] == "position";
    const bool of_ad = words.size() == 4 && words[1] == "ad";
    const auto value = of_position ? position(words[3]) : of_ad ? number(words[3], 0, highest_data) : std::nullopt;
    for (std::size_t i = 1; value && i < comparisons.size(); ++i)
        if (words[2] == comparisons[i])
            return pair(command(of_position ? until_position : until_ad, static_cast<int>(i)), *value);
    return wrong("until takes position or ad, one of = > < >= <=, and a number up to 254: until position >= 90");
}

Result wheel_from(const Words& words)
{
    const bool clockwise = words.size() == 3 && words[1] == "cw";
    const bool counter_clockwise = words.size() == 3 && words[1] == "ccw";
    const auto speed = clockwise || counter_clockwise ? number(words[2], 0, fastest_wheel) : std::nullopt;
    if (!speed)
        return wrong("wheel takes cw or ccw and a speed from 0 to 15: wheel cw 5");
    return pair(command(special, static_cast<int>(clockwise ? QuickSpin::clockwise : QuickSpin::counter_clockwise)),
                *speed);
}

Result outputs_from(const Words& words)
{
    int on = 0;
    for (const auto& word : std::span(words).subspan(1))
        if (word == "1" || word == "2")
            on |= word == "1" ? 1 : 2;
        else if (word != "none" || words.size() != 2)
            on = -1000;
    if (on < 0 || words.size() < 2)
        return wrong("outputs takes those that are on: outputs 1, outputs 1 2, or outputs none");
    return pair(command(outputs), on);
}

Result repeat_from(const Words& words)
{
    const bool forever = words.size() == 2 && words[1] == "forever";
    const auto count = words.size() == 2 && !forever ? number(words[1], 1, highest_data) : std::nullopt;
    if (!forever && !count)
        return wrong("repeat takes a count from 1 to 254, or forever");
    return pair(command(repeat), count.value_or(0));
}

Result alone(const Words& words, std::uint8_t first)
{
    if (words.size() > 1)
        return wrong(fmt::format("{} takes nothing", words.front()));
    return pair(first, 0);
}

Result instruction_from(const Words& words)
{
    const auto verb = words.front();
    if (verb == "go")
        return go_from(words);
    if (verb == "wait")
        return wait_from(words);
    if (verb == "until")
        return until_from(words);
    if (verb == "wheel")
        return wheel_from(words);
    if (verb == "outputs")
        return outputs_from(words);
    if (verb == "repeat")
        return repeat_from(words);
    if (verb == "passive" || verb == "brake")
        return alone(words, command(special, verb == "passive" ? 1 : 2));
    if (verb == "end")
        return alone(words, command(end));
    const auto near = did_you_mean(verb, verbs);
    return wrong(fmt::format("there is no instruction '{}'{}", verb,
                             near.empty() ? fmt::format("; there are {}", fmt::join(verbs, ", ")) : near));
}

Words split(std::string_view line)
{
    Words out;
    line = line.substr(0, line.find('#'));
    constexpr std::string_view blanks = " \t\r";
    while (true) {
        const auto begin = line.find_first_not_of(blanks);
        if (begin == std::string_view::npos)
            return out;
        line.remove_prefix(begin);
        const auto length = std::min(line.find_first_of(blanks), line.size());
        out.push_back(line.substr(0, length));
        line.remove_prefix(length);
    }
}

std::string text_of(wire::Pair instruction)
{
    const int number = instruction.first >> 4;
    const int sub = instruction.first & 0x0F;
    const int data = instruction.second;
    switch (number) {
    case go:
        if (sub > weakest_level)
            break;
        return fmt::format("go {}{}", data, sub == 0 ? "" : fmt::format(" level {}", sub));
    case special:
        if (sub == 1 || sub == 2)
            return sub == 1 ? "passive" : "brake";
        if ((sub == 3 || sub == 4) && data <= fastest_wheel)
            return fmt::format("wheel {} {}", sub == 4 ? "cw" : "ccw", data);
        break;
    case delay:
        return fmt::format("wait {}ms", sub << 8 | data);
    case outputs:
        if (data > 3)
            break;
        return data == 0 ? "outputs none"
                         : fmt::format("outputs{}{}", (data & 1) != 0 ? " 1" : "", (data & 2) != 0 ? " 2" : "");
    case until_position:
    case until_ad:
        if (sub < 1 || sub > 5)
            break;
        return fmt::format("until {} {} {}", number == until_position ? "position" : "ad",
                           comparisons[static_cast<std::size_t>(sub)], data);
    case repeat:
        return data == 0 ? "repeat forever" : fmt::format("repeat {}", data);
    case end:
        return "end";
    default:
        break;
    }
    return fmt::format("# {:02X} {:02X}: no document explains it", instruction.first, instruction.second);
}

} // namespace

std::optional<double> goes_to_rad(wire::Pair instruction)
{
    return instruction.first >> 4 == go
               ? std::optional(units::rad((instruction.second - boundary_centre) * deg_per_unit))
               : std::nullopt;
}

bool turns_on(wire::Pair instruction)
{
    const int sub = instruction.first & 0x0F;
    return instruction.first >> 4 == special && (sub == 3 || sub == 4) && instruction.second != 0;
}

std::expected<Program, Error> assemble(std::string_view text, std::string_view path)
{
    Program out;
    for (int line = 1; !text.empty(); ++line) {
        const auto length = std::min(text.find('\n'), text.size());
        const auto words = split(text.substr(0, length));
        text.remove_prefix(std::min(length + 1, text.size()));
        if (words.empty())
            continue;
        const auto instruction = instruction_from(words);
        if (!instruction)
            return fail(Errc::bad_file, fmt::format("{}:{}: {}", path, line, instruction.error()));
        if (out.instructions.size() == most_instructions)
            return fail(Errc::bad_file,
                        fmt::format("{}:{}: a program has at most {} instructions", path, line, most_instructions));
        out.instructions.push_back(*instruction);
        out.places.push_back(fmt::format("{}:{}", path, line));
    }
    if (out.instructions.empty())
        return fail(Errc::bad_file, fmt::format("{}: there is no instruction in it", path));
    return out;
}

std::string disassemble(std::span<const wire::Pair> instructions)
{
    std::string out;
    for (const auto& instruction : instructions)
        out += text_of(instruction) + '\n';
    return out;
}

} // namespace sinew::sam
