#include "sinew/diagnosis/doctor.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/link_report.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/session.hpp"
#include "apps/cli/terminal.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

using diagnosis::Examination;
using diagnosis::Finding;
using diagnosis::Severity;
using diagnosis::Subject;

/// One subject for each bus, with its joints in the order of the file.
std::expected<std::vector<Subject>, Error> subjects_of_robot(const Words& words, const std::string& path)
{
    const auto devices = robot_at(words, path);
    if (!devices)
        return std::unexpected(devices.error());
    std::vector<Subject> out;
    for (const auto& device : *devices) {
        const auto& bus = *device.file->find_bus(device.joint->bus.value);
        auto known = std::ranges::find(out, bus.name, &Subject::bus);
        if (known == out.end())
            known =
                out.insert(out.end(), {.bus = bus.name,
                                       .link = device.link,
                                       .family = device.family,
                                       .bit_rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : 0});
        known->expected.push_back({device.id, device.name, *device.spec});
    }
    return out;
}

std::expected<std::vector<Subject>, Error> subject_of_link(const Words& words, std::string link)
{
    if (link.starts_with('/'))
        link = "serial:" + link;
    const auto uri = link::parse_uri(link);
    if (!uri)
        return std::unexpected(uri.error());
    Subject out{.rate_is_guessed = !uri->option("baud").has_value()};
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        out.family = *family;
    }
    out.link = with_bit_rate(link, out.family != nullptr ? *out.family : *find_family("sam"));
    return std::vector{std::move(out)};
}

std::unexpected<Error> no_examination(const std::string& recording)
{
    return fail(Errc::bad_argument, fmt::format("{} is a recording, whose wires cannot be asked anything new; sinew "
                                                "replay {} --errors shows what went wrong on them",
                                                recording, recording));
}

std::expected<std::vector<Subject>, Error> subjects(const Words& words)
{
    auto what = words.text("WHAT");
    const char* environment = std::getenv("SINEW_ROBOT");
    if (!what && environment == nullptr)
        return fail(Errc::bad_argument, "what is to be looked at? Name a link, such as serial:/dev/ttyUSB0, or a robot "
                                        "file, such as arm.toml");
    const bool is_named = what.has_value();
    if (!is_named)
        what = environment;
    if (is_recording(*what))
        return no_examination(*what);
    if (is_named && record::is_replay(*what))
        return no_examination(link::parse_uri(*what)->target);
    if (is_named && !is_robot_file(*what) && is_link(*what))
        return subject_of_link(words, *what);
    if (auto fine = no_family_for(words); !fine)
        return std::unexpected(fine.error());
    return subjects_of_robot(words, *what);
}

void print_finding(const Finding& finding)
{
    end_progress();
    const bool is_narrow = columns() < 50;
    const std::size_t indent = is_narrow ? 4 : 11;
    const std::string severity(to_word(finding.severity));
    const auto head =
        is_narrow ? fmt::format("  {} {}", severity, finding.name) : fmt::format("  {:<7}  {}", severity, finding.name);
    const auto line = finding.evidence.empty() ? head : fmt::format("{}: {}", head, finding.evidence);
    const auto margin = line.find_first_not_of(' ');
    const auto text = wrap(line.substr(margin), indent, columns());
    fmt::print("{}{}\n", std::string(margin, ' '), finding.severity >= Severity::warning ? bold(text) : text);
    if (finding.severity == Severity::ok)
        return;
    const std::string space(indent, ' ');
    fmt::print("{}{}\n", space, wrap(finding.meaning, indent, columns()));
    fmt::print("{}{}\n", space, wrap("Try: " + finding.next, indent, columns()));
}

Json to_json(const Finding& finding)
{
    return Json::object({{"name", finding.name},
                         {"check", finding.check},
                         {"severity", to_word(finding.severity)},
                         {"id", finding.id >= 0 ? Json(finding.id) : Json()},
                         {"joint", finding.joint.empty() ? Json() : Json(finding.joint)},
                         {"evidence", finding.evidence},
                         {"meaning", finding.meaning.empty() ? Json() : Json(finding.meaning)},
                         {"next", finding.next.empty() ? Json() : Json(finding.next)}});
}

Json to_json(const Subject& subject, const Examination& examination)
{
    Json findings = Json::array();
    for (const auto& finding : examination.findings)
        findings.add(to_json(finding));
    Json left_out = Json::array();
    for (const auto check : examination.left_out)
        left_out.add(check);
    return Json::object({{"bus", subject.bus.empty() ? Json() : Json(subject.bus)},
                         {"link", subject.link},
                         {"findings", findings},
                         {"left_out", left_out},
                         {"adapter", report_json(examination.adapter)}});
}

void print_verdict(std::span<const Finding> all)
{
    const auto count = [&](Severity severity) { return std::ranges::count(all, severity, &Finding::severity); };
    std::vector<std::string> parts;
    const auto add = [&](Severity severity) {
        if (const auto n = count(severity); n > 0)
            parts.push_back(fmt::format("{} {}{}", n, to_word(severity), n == 1 ? "" : "s"));
    };
    add(Severity::error);
    add(Severity::warning);
    add(Severity::note);
    fmt::print("{}\n", parts.empty() ? "All is well." : fmt::format("{}.", fmt::join(parts, ", ")));
}

int exit_code_of(Severity worst)
{
    return worst == Severity::error     ? exit_diagnosed_error
           : worst == Severity::warning ? exit_diagnosed_warning
                                        : exit_done;
}

Outcome run(const Words& words)
{
    const auto all = subjects(words);
    if (!all)
        return std::unexpected(all.error());
    Session session;
    Json links = Json::array();
    std::vector<Finding> findings;
    for (const auto& subject : *all) {
        if (!words.json())
            fmt::print("{}\n",
                       bold(subject.bus.empty() ? subject.link : fmt::format("{}  {}", subject.bus, subject.link)));
        diagnosis::Surroundings around{.open = [&](const std::string& link) -> std::expected<diagnosis::Opened, Error> {
                                           auto opened = session.open(link);
                                           if (!opened)
                                               return std::unexpected(opened.error());
                                           return diagnosis::Opened{std::move(*opened), &session.clock()};
                                       },
                                       .progress = [](std::string_view text) { progress(text); },
                                       .stopped = interrupted};
        if (!words.json())
            around.found = print_finding;
        const auto examination = diagnosis::examine(subject, around);
        end_progress();
        if (!words.json() && !examination.left_out.empty())
            fmt::print("  {}\n",
                       wrap(fmt::format("not possible: {}", fmt::join(examination.left_out, ", ")), 4, columns()));
        links.add(to_json(subject, examination));
        findings.insert(findings.end(), examination.findings.begin(), examination.findings.end());
        if (interrupted())
            break;
    }
    const auto worst = diagnosis::worst(findings);
    if (words.json())
        print(Json::object({{"worst", to_word(worst)}, {"complete", !interrupted()}, {"links", links}}));
    else
        print_verdict(findings);
    return interrupted() ? exit_interrupted : exit_code_of(worst);
}

} // namespace

Verb doctor_verb()
{
    return {
        .name = "doctor",
        .says = "Look at a link or at all of a robot, and say what is wrong and what to try next.",
        .arguments = {{"WHAT", "a link, or a robot file; SINEW_ROBOT where it is left out", false}},
        .options = {sim_option,
                    link_option,
                    {"--family", "F", "of the devices on the link; left out: whoever answers"},
                    json_option},
        .examples = {{"sinew doctor serial:/dev/ttyUSB0?baud=1500000", "an adapter, and whoever answers there"},
                     {"sinew doctor arm.toml", "a robot: all its buses and joints"},
                     {"sinew doctor robots/demo.toml --link left=pty:/dev/pts/5", "one that is simulated elsewhere"}},
        .run = run,
        .more = "It only reads: nothing moves and nothing is stored. Port, permission, other programs, adapter, "
                "echo, bit rate, ids, duplicates, settings, supply, faults and lost answers are looked at in this "
                "order; what fails does not hide what comes after it. Each finding has a name that stays, and a "
                "page under docs/troubleshooting.",
        .ends = {exit_diagnosed_warning, exit_diagnosed_error}};
}

} // namespace sinew::cli
