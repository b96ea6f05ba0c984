#include "apps/cli/exit_codes.hpp"
#include "apps/cli/help.hpp"
#include "apps/cli/verb.hpp"
#include "sinew/base/bytes.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// Text as roff takes it: dashes that stay dashes, no line that begins with a command.
std::string roff(std::string_view text)
{
    std::string out;
    for (const char c : text)
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if (c == '\'')
            out += "\\(aq";
        else if (c == '`')
            out += "\\(ga";
        else
            out += c;
    return out.starts_with('.') ? "\\&" + out : out;
}

std::string term(std::string_view name, std::string_view value, std::string_view says)
{
    const auto place = value.empty() ? std::string{} : fmt::format(" \\fI{}\\fR", roff(value));
    return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), place, roff(says));
}

std::string synopsis(const Verb& verb)
{
    std::string out = fmt::format("\\fBsinew {}\\fR", roff(verb.name));
    for (const auto& a : verb.arguments)
        out += fmt::format(" {}\\fI{}\\fR{}{}", a.required ? "" : "[", roff(a.name), a.many ? " ..." : "",
                           a.required ? "" : "]");
    return out + (verb.options.empty() ? "" : " [\\fIoptions\\fR]");
}

/// Arguments, options, what else must be known, and examples, under headings of this macro.
std::string body(const Verb& verb, std::string_view heading)
{
    std::string out;
    if (!verb.arguments.empty() && heading == ".SH")
        out += ".SH ARGUMENTS\n";
    for (const auto& a : verb.arguments)
        out += term(a.name, "", a.says);
    if (!verb.options.empty() && heading == ".SH")
        out += ".SH OPTIONS\n";
    for (const auto& o : verb.options)
        out += term(o.name, o.value, o.says);
    if (!verb.more.empty())
        out += (heading == ".SH" ? ".SH NOTES\n" : ".PP\n") + roff(verb.more) + '\n';
    if (!verb.examples.empty() && heading == ".SH")
        out += ".SH EXAMPLES\n";
    for (const auto& e : verb.examples)
        out += fmt::format(".PP\n{}:\n.PP\n.RS 4\n.EX\n{}\n.EE\n.RE\n", roff(e.says), roff(e.line));
    if (heading == ".SH") {
        out += ".SH EXIT STATUS\n";
        for (const auto& [number, says] : exit_codes_of(verb))
            out += term(std::to_string(number), "", says);
    }
    return out;
}

std::string head(std::string_view title, std::string_view says)
{
    return fmt::format(".TH \"{}\" \"1\" \"\" \"sinew {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", roff(title),
                       SINEW_VERSION, roff(title), roff(says));
}

std::string page(const Verb& verb)
{
    std::string name = fmt::format("sinew-{}", verb.name);
    for (char& c : name)
        c = c == ' ' ? '-' : c;
    std::string says(verb.says);
    if (says.ends_with('.'))
        says.pop_back();
    return head(name, says) + ".SH SYNOPSIS\n" + synopsis(verb) + "\n.SH DESCRIPTION\n" + roff(verb.says) + '\n' +
           body(verb, ".SH") + ".SH SEE ALSO\nsinew(1)\n";
}

std::string page()
{
    std::string out = head("sinew", "talks to smart actuators of the families SAM, Nuri and RMD");
    out += ".SH SYNOPSIS\n\\fBsinew\\fR \\fIVERB\\fR [\\fIarguments\\fR] [\\fIoptions\\fR]\n";
    out += ".SH DESCRIPTION\nReal actuators or simulated ones. Data goes to stdout, words go to stderr.\n.SH VERBS\n";
    for (const auto& verb : verbs())
        out += ".SS " + synopsis(verb) + '\n' + roff(verb.says) + '\n' + body(verb, ".PP");
    for (const auto& topic : help_topics()) {
        out += fmt::format(".SH {}\n", roff(topic.title));
        for (const auto& [name, says] : topic.rows())
            out += term(name, "", says);
    }
    return out;
}

Outcome run(const Words& words)
{
    const auto parts = words.all("VERB");
    if (parts.empty()) {
        fmt::print("{}", page());
        return exit_done;
    }
    std::string name = parts.front();
    for (const auto& part : parts.subspan(1))
        name += ' ' + part;
    std::vector<std::string_view> names;
    for (const auto& verb : verbs()) {
        if (verb.name == name) {
            fmt::print("{}", page(verb));
            return exit_done;
        }
        names.push_back(verb.name);
    }
    return fail(Errc::unknown_name, fmt::format("there is no verb '{}'{}", name, did_you_mean(name, names)));
}

} // namespace

Verb man_verb()
{
    return {.name = "man",
            .says = "Print the manual page of the command, or of one verb, for man(1).",
            .arguments = {{"VERB", "of this verb only", false, true}},
            .examples = {{"sinew man", "to read it: sinew man | man -l -"}, {"sinew man sim step", "of one verb"}},
            .run = run};
}

} // namespace sinew::cli
