#include "apps/cli/help.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/terminal.hpp"

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
        out += fmt::format("  {}\n      {}\n", wrap(e.line, 6, fits()), wrap(e.says, 6, fits()));
    return out + "\nExit codes: sinew --help\n";
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
    out += section("Environment",
                   {{"SINEW_ROBOT", "the robot file, where --robot is not given"},
                    {"SINEW_PATIENCE",
                     "how long a slow or busy host may let an answer lie, such as 500ms; without it what its answers "
                     "were measured to take"},
                    {"NO_COLOR", "no bold text"}});
    rows.clear();
    for (const auto& code : exit_codes())
        rows.emplace_back(std::to_string(code.number), code.says);
    return out + section("Exit codes", rows);
}

} // namespace sinew::cli
