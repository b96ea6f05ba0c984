#include "sinew/diagnosis/walk.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/by_name.hpp"
#include "sinew/wire/values.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

/// One value of a Nuri, whose lines have rows of their own; nothing where the line has none such, or no answer came.
std::expected<std::optional<double>, Error> ask(Walk& walk, const Patient& patient, const nuri::Spec& spec,
                                                std::string_view message, std::string_view field)
{
    const auto& line = spec.profile.line;
    const auto request =
        wire::make_request(line, message, patient.id, {}, spec.profile.options(), spec.profile.response_time());
    if (!request)
        return std::nullopt;
    const auto look = walk.read(*request, walk.patience());
    if (!look)
        return std::unexpected(look.error());
    if (!*look || !(*look)->reply)
        return std::nullopt;
    const auto said = wire::decode(*request->message, wire::Direction::reply, *(*look)->reply, request->options);
    if (!said)
        return std::nullopt;
    for (const auto& value : said->values)
        if (value.field->name == field)
            return wire::reading(*request->message, *value.field, line.overrides).physical(value.raw);
    return std::nullopt;
}

// ---- response level and time ----

/// A SAM that is silent, or may be.
bool look_for_silence(Walk& walk, const Patient& patient)
{
    const bool is_gone = patient.expected && !patient.present && !patient.elsewhere;
    const bool others_answer = !walk.present().empty() && !walk.has("broken-chain");
    if (!std::holds_alternative<sam::Spec>(*patient.spec) || !is_gone || !(patient.silent() || others_answer))
        return false;
    walk.add(patient, "silent-response-level",
             patient.silent() ? fmt::format("the robot file says so of {}", Walk::name_of(patient))
                              : fmt::format("{} does not answer at any bit rate, and others on the same cable do",
                                            Walk::name_of(patient)))
        .severity = Severity::warning;
    return true;
}

Checked compare_level(Walk& walk, const Patient& patient, const sam::Spec& spec)
{
    const auto said = walk.call<sam::ReadDriveMode>(patient);
    if (!said)
        return std::unexpected(said.error());
    if (*said && (*said)->response_level != spec.profile.response_level)
        walk.add(patient, "response-level-differs",
                 fmt::format("{} is at level {}, and the robot file says {}", Walk::name_of(patient),
                             (*said)->response_level, spec.profile.response_level),
                 fmt::format("Write response_level = {} under profile_options of the joint.", (*said)->response_level));
    return {};
}

Checked compare_time(Walk& walk, const Patient& patient, const nuri::Spec& spec)
{
    const auto time_us = ask(walk, patient, spec, "request-response-time-feedback", "response_time");
    if (!time_us)
        return std::unexpected(time_us.error());
    if (*time_us && **time_us > spec.profile.response_time_us)
        walk.add(patient, "response-time-differs",
                 fmt::format("{} waits {:g} us, and the robot file says {:g}", Walk::name_of(patient), **time_us,
                             spec.profile.response_time_us),
                 fmt::format("Write response_time_us = {:g} under profile_options of the joint.", **time_us));
    return {};
}

// ---- scales ----

Checked check_sam(Walk& walk, const Patient& patient, const sam::Spec& spec)
{
    const auto says = walk.call<sam::ReadFirmwareVersion>(patient);
    if (!says)
        return std::unexpected(says.error());
    if (!*says || (*says)->model_number == spec.model->number)
        return {};
    const auto* model = sam::find_model((*says)->model_number);
    walk.add(patient, "wrong-model",
             fmt::format("{} says that it is {}, and the robot file says {}", Walk::name_of(patient),
                         model != nullptr
                             ? std::string(model->name)
                             : fmt::format("model number {}, which nobody documents", (*says)->model_number),
                         spec.model->name),
             model != nullptr ? fmt::format("Write model = \"{}\" for the joint.", model->name) : std::string{});
    return {};
}

Checked check_nuri(Walk& walk, const Patient& patient, const nuri::Spec& spec)
{
    const auto ratio = ask(walk, patient, spec, "request-gear-ratio-feedback", "gear_ratio");
    if (!ratio)
        return std::unexpected(ratio.error());
    constexpr double half_a_step = 0.05;
    if (*ratio && std::abs(**ratio - spec.profile.external_gear_ratio) > half_a_step)
        walk.add(patient, "wrong-scale",
                 fmt::format("{} has the gear ratio {:g}, and the robot file says {:g}", Walk::name_of(patient),
                             **ratio, spec.profile.external_gear_ratio),
                 fmt::format("Write external_gear_ratio = {:g} under profile_options of the joint.", **ratio));
    return {};
}

/// What a firmware line would make of an answer to read-status1.
std::optional<double> voltage_as(const wire::Profile& line, const wire::Frame& reply)
{
    const auto* message = line.find("read-status1");
    if (message == nullptr)
        return std::nullopt;
    const auto said = wire::decode(*message, wire::Direction::reply, reply, line.options);
    if (!said)
        return std::nullopt;
    for (const auto& value : said->values)
        if (value.field->name == "voltage")
            return wire::reading(*message, *value.field, line.overrides).physical(value.raw);
    return std::nullopt;
}

/// Supplies that such a motor can run on at all.
bool is_plausible(std::optional<double> voltage_v)
{
    return voltage_v && *voltage_v >= 5.0 && *voltage_v <= 70.0;
}

void check_max_speed(Walk& walk, const Patient& patient, const rmd::Spec& spec)
{
    const auto& profile = spec.profile;
    const auto lines = rmd::profiles();
    const auto line = std::ranges::find(lines, profile.line.name, [](const rmd::Profile& p) { return p.line.name; });
    if (!profile.max_speed_confirmed)
        walk.add(patient, "unconfirmed-scale",
                 fmt::format("{}: max_speed may count 0.01 or 1 deg/s; {:g} is taken", Walk::name_of(patient),
                             profile.sent_max_speed_lsb_dps()));
    else if (line != lines.end() && line->max_speed_lsb_dps != profile.max_speed_lsb_dps)
        walk.add(patient, "wrong-scale",
                 fmt::format("{}: the robot file says max_speed_lsb_dps = {:g}, and {} has {:g}",
                             Walk::name_of(patient), profile.max_speed_lsb_dps, profile.line.name,
                             line->max_speed_lsb_dps),
                 fmt::format("Take max_speed_lsb_dps out of profile_options, unless a slow first move with a low "
                             "--speed has shown "
                             "that it is right; a scale that is wrong is a hundred times too fast."))
            .severity = Severity::warning;
}

Checked check_rmd(Walk& walk, const Patient& patient, const rmd::Spec& spec)
{
    const auto* message = spec.profile.line.find("read-status1");
    const auto request = message == nullptr ? std::unexpected(Error{})
                                            : wire::make_request(spec.profile.line, "read-status1", patient.id, {},
                                                                 spec.profile.options(), rmd::response_time);
    if (!request)
        return {};
    const auto look = walk.read(*request, walk.patience());
    if (!look)
        return std::unexpected(look.error());
    if (!*look || !(*look)->reply)
        return {};
    const auto& reply = *(*look)->reply;
    const auto own = voltage_as(spec.profile.line, reply);
    std::vector<std::string> better;
    std::string first;
    for (const auto& other : rmd::profiles())
        if (other.line.options.can_reply_base == spec.profile.line.options.can_reply_base &&
            is_plausible(voltage_as(other.line, reply))) {
            better.push_back(fmt::format("{:g} V and max_speed in {:g} deg/s as {}", *voltage_as(other.line, reply),
                                         other.max_speed_lsb_dps, other.line.name));
            first = first.empty() ? std::string(other.line.name) : first;
        }
    if (is_plausible(own) || better.empty()) {
        check_max_speed(walk, patient, spec);
        return {};
    }
    walk.add(patient, "wrong-profile",
             fmt::format("{} reads as {:g} V on a {} (max_speed in {:g} deg/s), which cannot be; it would be {}",
                         Walk::name_of(patient), own.value_or(0.0), spec.profile.line.name,
                         spec.profile.max_speed_lsb_dps, better.front()),
             fmt::format(
                 "Write profile = \"{}\" for the joint, if the papers of the motor agree; until then do not move it.",
                 first));
    return {};
}

} // namespace

Checked check_response_level(Walk& walk)
{
    if (walk.family == nullptr || walk.family->can)
        return {};
    const auto before = walk.count();
    bool looked = false;
    for (const auto& patient : walk.patients) {
        if (!patient.expected || look_for_silence(walk, patient) || !patient.present || patient.doubled)
            continue;
        looked = true;
        Checked done;
        if (const auto* sam = std::get_if<sam::Spec>(&*patient.spec))
            done = compare_level(walk, patient, *sam);
        else if (const auto* nuri = std::get_if<nuri::Spec>(&*patient.spec))
            done = compare_time(walk, patient, *nuri);
        if (!done)
            return done;
    }
    if (looked && walk.count() == before)
        walk.fine("response-level", walk.family->name == "sam" ? "as the robot file says"
                                                               : "nobody answers later than the robot file says");
    return {};
}

Checked check_scales(Walk& walk)
{
    const auto before = walk.count();
    int looked = 0;
    for (const auto* patient : walk.readable()) {
        if (!patient->expected || !patient->spec)
            continue;
        ++looked;
        walk.progress(fmt::format("comparing {} with the robot file", Walk::name_of(*patient)));
        const auto done = std::visit(
            [&]<class Spec>(const Spec& spec) -> Checked {
                if constexpr (std::is_same_v<Spec, sam::Spec>)
                    return check_sam(walk, *patient, spec);
                else if constexpr (std::is_same_v<Spec, nuri::Spec>)
                    return check_nuri(walk, *patient, spec);
                else
                    return check_rmd(walk, *patient, spec);
            },
            *patient->spec);
        if (!done)
            return done;
    }
    if (looked > 0 && walk.count() == before)
        walk.fine("scales", "nothing that the devices say of themselves contradicts the robot file");
    return {};
}

} // namespace sinew::diagnosis
