#include "apps/cli/help.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/link/links.hpp"
#include "sinew/record/replay.hpp"
#include "sinew/sim/links.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr std::size_t widest = 80;

std::size_t fits()
{
    return std::min(columns(), widest);
}

/// Terms and what they mean, the meaning beside the term or, where that is too narrow, below it.
std::string list(const std::vector<std::pair<std::string, std::string>>& rows)
{
    std::size_t longest = 0;
    for (const auto& [term, says] : rows)
        longest = std::max(longest, width(term));
    const bool beside = longest + 4 + 30 <= fits();
    const std::size_t indent = beside ? longest + 4 : 6;
    std::string out;
    for (const auto& [term, says] : rows) {
        const std::string space =
            beside ? std::string(longest + 2 - width(term), ' ') : '\n' + std::string(indent, ' ');
        out += fmt::format("  {}{}{}\n", term, space, wrap(says, indent, fits()));
    }
    return out;
}

std::string section(std::string_view title, const std::vector<std::pair<std::string, std::string>>& rows)
{
    return rows.empty() ? std::string{} : fmt::format("\n{}\n{}", bold(title), list(rows));
}

std::string paragraph(std::string_view text)
{
    return wrap(text, 0, fits()) + '\n';
}

/// A command as a shell takes it, also where it is longer than a line.
std::string command_line(std::string_view line)
{
    constexpr std::string_view goes_on = " \\";
    if (2 + width(line) <= fits())
        return std::string(line);
    std::string out;
    for (const char c : wrap(line, 6, fits() - goes_on.size()))
        out += c == '\n' ? fmt::format("{}\n", goes_on) : std::string(1, c);
    return out;
}

using Rows = std::vector<std::pair<std::string, std::string>>;

Rows exit_code_rows()
{
    Rows out;
    for (const auto& code : exit_codes())
        out.emplace_back(std::to_string(code.number), code.of_motion.empty() ? code.says : code.of_motion);
    return out;
}

Rows exit_code_rows(const Verb& verb)
{
    Rows out;
    for (const auto& [number, says] : exit_codes_of(verb))
        out.emplace_back(std::to_string(number), says);
    return out;
}

Rows environment_rows()
{
    return {{"SINEW_ROBOT", "the robot file, where --robot is not given"},
            {"SINEW_PATIENCE",
             "how long a slow or busy host may let an answer lie, such as 500ms; without it what its answers were "
             "measured to take"},
            {"XDG_STATE_HOME",
             "where the count of flash writes is kept (sinew/flash-writes.toml); ~/.local/state where it "
             "is not set"},
            {"XDG_RUNTIME_DIR", "where a simulator that runs is found"},
            {"COLUMNS", "how wide the text is, where there is no terminal"},
            {"NO_COLOR", "no bold text"}};
}

Rows unit_rows()
{
    return {
        {"45deg, 0.785rad, 0.125turn", "angles on the command line, always with their unit"},
        {"30deg/s, 30dps, 0.5rad/s, 5rpm", "speeds"},
        {"10s, 500ms, 2min", "times; a number alone is seconds"},
        {"0.5A, 0.2Nm", "currents and torques of sinew move"},
        {"speed=0x10, mode=brake, speed=90dps", "fields of messages: numbers as they are on the wire, words, or values "
                                                "with the unit of the row"},
        {"JSON, CSV", "SI, with the unit in the name: position_rad, velocity_rad_s, current_a, torque_nm, voltage_v, "
                      "temperature_c, time_s"},
        {"robot files", "as in JSON, and angles in degrees under names that end in _deg and _deg_s"}};
}

Rows link_rows()
{
    auto links = link::Links::system();
    sim::Worlds worlds;
    sim::add(links, worlds);
    record::Replays replays;
    record::add(links, replays);
    Rows out;
    for (const auto& scheme : links.schemes())
        out.emplace_back(scheme.form, scheme.says);
    return out;
}

} // namespace

std::string usage(const Verb& verb)
{
    std::string out = fmt::format("sinew {}", verb.name);
    for (const auto& a : verb.arguments)
        out += fmt::format(" {}{}{}{}", a.required ? "" : "[", a.name, a.many ? "..." : "", a.required ? "" : "]");
    return out + (verb.options.empty() ? "" : " [options]");
}

std::string help(const Verb& verb)
{
    std::string out = bold(wrap(usage(verb), 2, fits())) + "\n\n" + paragraph(verb.says);
    std::vector<std::pair<std::string, std::string>> rows;
    for (const auto& a : verb.arguments)
        rows.emplace_back(a.name, a.says);
    out += section("Arguments", rows);
    rows.clear();
    for (const auto& o : verb.options)
        rows.emplace_back(fmt::format("{}{}{}", o.name, o.value.empty() ? "" : " ", o.value), o.says);
    rows.emplace_back("--help", "show this");
    out += section("Options", rows);
    if (!verb.more.empty())
        out += '\n' + paragraph(verb.more);
    if (!verb.examples.empty())
        out += fmt::format("\n{}\n", bold("Examples"));
    for (const auto& e : verb.examples)
        out += fmt::format("  {}\n      {}\n", command_line(e.line), wrap(e.says, 6, fits()));
    return out + section("Exit codes", exit_code_rows(verb));
}

std::string help()
{
    std::string out = bold("sinew VERB [arguments] [options]") + "\n\n" +
                      paragraph("Talks to smart actuators of the families SAM, Nuri and RMD, real or simulated. Data "
                                "goes to stdout, words go to stderr.");
    std::vector<std::pair<std::string, std::string>> rows;
    for (const auto& verb : verbs())
        rows.emplace_back(verb.name, verb.says);
    out += section("Verbs", rows);
    out += section("Options",
                   {{"--help", "show this; after a verb: what that verb takes"}, {"--version", "show the version"}});
    out += section("Environment", environment_rows());
    rows.clear();
    for (const auto& topic : help_topics())
        rows.emplace_back(fmt::format("sinew help {}", topic.name), std::string(topic.says));
    out += section("More", rows);
    return out + section("Exit codes", exit_code_rows());
}

std::span<const HelpTopic> help_topics()
{
    static constexpr HelpTopic all[] = {
        {"units", "UNITS", "how angles, speeds and times are written", unit_rows},
        {"exit-codes", "EXIT CODES", "what the command leaves behind for scripts", exit_code_rows},
        {"environment", "ENVIRONMENT", "the variables that count", environment_rows},
        {"links", "LINKS", "how a port is named", link_rows},
    };
    return all;
}

std::string help(const HelpTopic& topic)
{
    return section(topic.title, topic.rows()).substr(1);
}

std::string help_json()
{
    Json all = Json::array();
    for (const auto& verb : verbs()) {
        Json arguments = Json::array();
        for (const auto& a : verb.arguments)
            arguments.add(
                Json::object({{"name", a.name}, {"says", a.says}, {"required", a.required}, {"many", a.many}}));
        Json options = Json::array();
        for (const auto& o : verb.options)
            options.add(Json::object({{"name", o.name}, {"value", o.value}, {"says", o.says}, {"many", o.many}}));
        Json codes = Json::array();
        for (const auto& [number, says] : exit_codes_of(verb))
            codes.add(number);
        Json examples = Json::array();
        for (const auto& e : verb.examples)
            examples.add(Json::object({{"line", e.line}, {"says", e.says}}));
        all.add(Json::object({{"name", verb.name},
                              {"says", verb.says},
                              {"arguments", std::move(arguments)},
                              {"options", std::move(options)},
                              {"examples", std::move(examples)},
                              {"exit_codes", std::move(codes)},
                              {"more", verb.more}}));
    }
    return all.pretty() + "\n";
}

} // namespace sinew::cli
