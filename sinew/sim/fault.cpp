#include "sinew/sim/fault.hpp"

#include "sinew/family/apply.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

namespace sinew::sim {
namespace {

using enum FaultKind;

constexpr FaultKindInfo kinds[] = {
    {"flip-bits", flip_bits, true, true, "probability", "a bit of a byte is turned over"},
    {"drop-bytes", drop_bytes, true, true, "probability", "a byte is lost"},
    {"add-bytes", add_bytes, true, true, "probability", "a byte too many"},
    {"delay-replies", delay_replies, true, true, "delay_s", "answers come later than they should"},
    {"duplicate-id", duplicate_id, true, false, "id", "the device answers to the id of another one"},
    {"unplug", unplug, true, false, "", "its cable is out: no data and no power"},
    {"power-cut", power_cut, true, true, "", "no supply"},
    {"brown-out", brown_out, true, true, "voltage_v", "too little supply"},
    {"stuck-gear", stuck_gear, true, false, "", "the shaft does not turn"},
    {"hot-motor", hot_motor, true, false, "", "as if it had worked too hard"},
    {"wrong-baud", wrong_baud, true, false, "bit_rate", "the device works at another bit rate than its bus"},
    {"push", push, true, false, "torque_nm", "a torque from outside on its shaft"},
};

constexpr Option<Fault> options[] = {
    number<&Fault::at_s, 0.0, 1e9>("at_s", "seconds, 0 or more"),
    number<&Fault::for_s, 0.0, 1e9>("for_s", "seconds, 0 or more; 0 until it is taken back"),
    number<&Fault::probability, 0.0, 1.0>("probability", "a number from 0 to 1"),
    number<&Fault::delay_s, 0.0, 10.0>("delay_s", "seconds, 0 to 10"),
    number<&Fault::voltage_v, 0.0, 100.0>("voltage_v", "volts, 0 to 100"),
    number<&Fault::temperature_c, -40.0, 300.0>("temperature_c", "degrees Celsius, -40 to 300"),
    number<&Fault::torque_nm, -1e4, 1e4>("torque_nm", "newton metres, -10000 to 10000"),
    whole<&Fault::id, 0, 255>("id", "an id, 0 to 255"),
    whole<&Fault::bit_rate, 110, 4'000'000>("bit_rate", "bits per second, 110 to 4000000"),
};

std::vector<std::string_view> kind_words()
{
    return names_of(kinds, [](const FaultKindInfo& one) { return one.word; });
}

const FaultKindInfo* find_kind(std::string_view word)
{
    const auto found = std::ranges::find(kinds, word, &FaultKindInfo::word);
    return found == std::end(kinds) ? nullptr : &*found;
}

/// What is wrong with hitting this by that; empty: nothing.
std::string check_target(const config::RobotFile& file, const FaultKindInfo& kind, const Fault& fault)
{
    if (!fault.joint.empty() && !kind.hits_joint)
        return fmt::format("{} hits a bus, not a joint.", kind.word);
    if (!fault.bus.empty() && !kind.hits_bus)
        return fmt::format("{} hits a joint, not a bus.", kind.word);
    if (!fault.joint.empty() && file.find_joint(fault.joint) == nullptr)
        return no_such("the robot", "joint", fault.joint,
                       names_of(file.joints, [](const config::Joint& one) { return std::string_view(one.name); }));
    if (!fault.bus.empty() && file.find_bus(fault.bus) == nullptr)
        return no_such("the robot", "bus", fault.bus,
                       names_of(file.buses, [](const config::Bus& one) { return std::string_view(one.name); }));
    if (fault.joint.empty() == fault.bus.empty())
        return fmt::format("{} needs {}.", kind.word, kind.hits_bus ? "either a joint or a bus" : "a joint");
    return {};
}

OptionValue value_of(const std::string& text)
{
    std::int64_t whole = 0;
    const char* const end = text.data() + text.size();
    if (const auto read = std::from_chars(text.data(), end, whole); read.ec == std::errc{} && read.ptr == end)
        return whole;
    double real = 0.0;
    if (const auto read = std::from_chars(text.data(), end, real); read.ec == std::errc{} && read.ptr == end)
        return real;
    return text;
}

} // namespace

std::span<const FaultKindInfo> fault_kinds()
{
    return kinds;
}

const FaultKindInfo& info_of(FaultKind kind)
{
    return *std::ranges::find(kinds, kind, &FaultKindInfo::kind);
}

std::span<const Option<Fault>> fault_options()
{
    return options;
}

std::expected<Fault, Error> fault_of(const config::RobotFile& file, const config::Section& section)
{
    Fault fault;
    const FaultKindInfo* kind = nullptr;
    std::vector<config::Setting> rest;
    bool has_need = false;
    for (const config::Setting& setting : section.settings) {
        const auto* text = std::get_if<std::string>(&setting.value);
        if (setting.key != "kind" && setting.key != "joint" && setting.key != "bus") {
            rest.push_back(setting);
            continue;
        }
        if (text == nullptr)
            return config::fail_at(file, setting.at, fmt::format("{} must be a text in quotes.", setting.key));
        if (setting.key == "kind") {
            kind = find_kind(*text);
            if (kind == nullptr)
                return config::fail_at(file, setting.at, no_such("sim", "fault", *text, kind_words()));
        }
        if (setting.key == "joint")
            fault.joint = *text;
        if (setting.key == "bus")
            fault.bus = *text;
    }
    if (kind == nullptr)
        return config::fail_at(file, section.at,
                               fmt::format("a fault needs a kind: {}.", fmt::join(kind_words(), ", ")));
    fault.kind = kind->kind;
    if (std::string wrong = check_target(file, *kind, fault); !wrong.empty()) {
        config::Mark at = section.at;
        for (const config::Setting& setting : section.settings)
            if (setting.key == "joint" || setting.key == "bus")
                at = setting.at;
        return config::fail_at(file, at, std::move(wrong));
    }
    for (const config::Setting& setting : rest)
        has_need |= setting.key == kind->needs;
    if (!kind->needs.empty() && !has_need)
        return config::fail_at(file, section.at, fmt::format("{} needs {}.", kind->word, kind->needs));
    if (auto done = apply(file, rest, fault_options(), kind->word, "option", fault); !done)
        return std::unexpected(std::move(done.error()));
    return fault;
}

std::expected<Fault, Error> parse_fault(const config::RobotFile& file, std::span<const std::string> words)
{
    if (words.size() < 2)
        return fail(Errc::bad_argument, "a fault is TARGET KIND [KEY=VALUE…], such as: elbow unplug for_s=2");
    const FaultKindInfo* kind = find_kind(words[1]);
    if (kind == nullptr)
        return fail(Errc::unknown_name, no_such("sim", "fault", words[1], kind_words()));
    Fault fault{.kind = kind->kind};
    (file.find_bus(words[0]) != nullptr && file.find_joint(words[0]) == nullptr ? fault.bus : fault.joint) = words[0];
    if (std::string wrong = check_target(file, *kind, fault); !wrong.empty())
        return fail(Errc::unknown_name, std::move(wrong));
    bool has_need = false;
    for (const std::string& word : words.subspan(2)) {
        const auto equals = word.find('=');
        const std::string key = word.substr(0, equals);
        const auto option = std::ranges::find_if(options, [&](const auto& one) { return one.key == key; });
        if (option == std::end(options))
            return fail(Errc::unknown_name,
                        no_such(kind->word, "option", key, names_of(options, [](const auto& one) { return one.key; })));
        if (equals == std::string::npos || !option->set(fault, value_of(word.substr(equals + 1))))
            return fail(Errc::bad_argument, fmt::format("{} must be {}: write {}=VALUE.", key, option->says, key));
        has_need |= key == kind->needs;
    }
    if (!kind->needs.empty() && !has_need)
        return fail(Errc::bad_argument, fmt::format("{} needs {}=VALUE.", kind->word, kind->needs));
    return fault;
}

} // namespace sinew::sim
