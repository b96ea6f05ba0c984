#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/sim_control.hpp"
#include "apps/cli/verb.hpp"
#include "sinew/base/units.hpp"
#include "sinew/sim/fault.hpp"

#include <fmt/format.h>
#include <limits>
#include <sstream>

namespace sinew::cli {
namespace {

constexpr Option pid_option{"--pid", "N", "which simulator, when several are running"};

/// The answer to the question of a verb: its word and the arguments as they were written.
std::expected<std::string, Error> answer_to(const Words& words, std::string_view command,
                                            std::initializer_list<std::string_view> arguments)
{
    const auto pid = words.number("--pid", 1, std::numeric_limits<std::int32_t>::max());
    if (!pid)
        return std::unexpected(pid.error());
    std::string line(command);
    for (const std::string_view argument : arguments)
        for (const std::string& word : words.all(argument))
            line += ' ' + word;
    return ask_simulator(*pid, line);
}

Outcome ask(const Words& words, std::string_view command, std::initializer_list<std::string_view> arguments)
{
    const auto answer = answer_to(words, command, arguments);
    if (!answer)
        return std::unexpected(answer.error());
    fmt::print("{}", *answer);
    return exit_done;
}

/// A row of the simulator's table, which is in degrees.
Json look_json(const std::string& row)
{
    std::istringstream in(row);
    std::string name, mode, faults;
    double deg = 0.0, deg_s = 0.0, current_a = 0.0, voltage_v = 0.0, temperature_c = 0.0;
    in >> name >> mode >> deg >> deg_s >> current_a >> voltage_v >> temperature_c >> std::ws;
    std::getline(in, faults);
    return Json::object({{"name", name},
                         {"mode", mode},
                         {"position_rad", units::rad(deg)},
                         {"velocity_rad_s", units::rad(deg_s)},
                         {"current_a", current_a},
                         {"voltage_v", voltage_v},
                         {"temperature_c", temperature_c},
                         {"faults", faults}});
}

Outcome look(const Words& words)
{
    if (!words.json())
        return ask(words, "look", {"JOINT"});
    const auto answer = answer_to(words, "look", {"JOINT"});
    if (!answer)
        return std::unexpected(answer.error());
    std::istringstream lines(*answer);
    std::string row;
    std::getline(lines, row); // its head
    Json out = Json::array();
    while (std::getline(lines, row))
        out.add(look_json(row));
    print(out);
    return exit_done;
}

std::string kinds()
{
    std::string out = "Kinds: ";
    for (const auto& kind : sim::fault_kinds())
        out += fmt::format("{}{}{}{}", kind.word, kind.needs.empty() ? "" : " (",
                           kind.needs.empty() ? "" : std::string(kind.needs) + ")",
                           &kind == &sim::fault_kinds().back() ? ". " : ", ");
    return out + "Each lasts until sinew sim mend, or for for_s=SECONDS, and begins at once, or in at_s=SECONDS.";
}

} // namespace

Verb sim_look_verb()
{
    return {.name = "sim look",
            .says = "What the devices of the running simulator are doing.",
            .arguments = {{"JOINT", "only these; all of them when none is given", false, true}},
            .options = {pid_option, json_option},
            .examples = {{"sinew sim look elbow", "mode, position, speed, current, voltage, temperature, faults"}},
            .run = look};
}

Verb sim_fault_verb()
{
    static const std::string more = kinds();
    return {.name = "sim fault",
            .says = "Let something go wrong in the running simulator.",
            .arguments = {{"TARGET", "the joint or the bus that it hits"},
                          {"KIND", "what goes wrong, see below"},
                          {"KEY=VALUE", "how much and how long", false, true}},
            .options = {pid_option},
            .examples = {{"sinew sim fault elbow unplug for_s=2", "two seconds without its cable"},
                         {"sinew sim fault left flip-bits probability=0.001", "noise on a bus"}},
            .run = [](const Words& words) { return ask(words, "fault", {"TARGET", "KIND", "KEY=VALUE"}); },
            .more = more};
}

Verb sim_mend_verb()
{
    return {.name = "sim mend",
            .says = "Take back all faults of a joint or a bus in the running simulator.",
            .arguments = {{"TARGET", "the joint or the bus"}},
            .options = {pid_option},
            .examples = {{"sinew sim mend elbow", "plugged in again, and all else that was wrong with it"}},
            .run = [](const Words& words) { return ask(words, "mend", {"TARGET"}); }};
}

} // namespace sinew::cli
