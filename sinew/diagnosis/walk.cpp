#include "sinew/diagnosis/walk.hpp"

#include "sinew/diagnosis/probes.hpp"
#include "sinew/family/drivers.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::diagnosis {

Walk::Walk(const Subject& asked, const Surroundings& around, Examination& into)
    : subject(asked), family(asked.family), around_(around), into_(into)
{
    if (auto parsed = link::parse_uri(asked.link))
        uri = std::move(*parsed);
    for (const auto& one : asked.expected)
        patients.push_back({.id = one.id, .joint = one.joint, .spec = one.spec, .expected = true});
}

Finding& Walk::put(Finding finding)
{
    finding.bus = subject.bus;
    finding.link = subject.link;
    into_.findings.push_back(std::move(finding));
    return into_.findings.back();
}

void Walk::fine(std::string_view check, std::string evidence)
{
    put({.name = check, .check = check, .evidence = std::move(evidence)});
}

Finding& Walk::add(std::string_view name, std::string evidence, std::string next)
{
    const Kind& what = kind(name);
    return put({.name = what.name,
                .check = what.check,
                .severity = what.severity,
                .evidence = std::move(evidence),
                .meaning = what.meaning,
                .next = next.empty() ? std::string(what.next) : std::move(next)});
}

Finding& Walk::add(const Patient& patient, std::string_view name, std::string evidence, std::string next)
{
    Finding& finding = add(name, std::move(evidence), std::move(next));
    finding.id = patient.id;
    finding.joint = patient.joint;
    return finding;
}

bool Walk::has(std::string_view name) const
{
    return std::ranges::any_of(into_.findings, [&](const Finding& f) { return f.name == name; });
}

void Walk::progress(std::string_view text) const
{
    if (around_.progress)
        around_.progress(text);
}

void Walk::finish()
{
    for (; reported_ < into_.findings.size(); ++reported_)
        if (around_.found)
            around_.found(into_.findings[reported_]);
}

std::vector<Patient*> Walk::present()
{
    std::vector<Patient*> out;
    for (auto& patient : patients)
        if (patient.present)
            out.push_back(&patient);
    return out;
}

std::vector<Patient*> Walk::missing()
{
    std::vector<Patient*> out;
    for (auto& patient : patients)
        if (patient.expected && !patient.present && !patient.silent())
            out.push_back(&patient);
    return out;
}

std::vector<Patient*> Walk::readable()
{
    auto out = present();
    std::erase_if(out, [](const Patient* patient) { return patient->doubled; });
    return out;
}

Patient Walk::patient_of(const Found& found)
{
    Patient out{.id = found.id, .present = true};
    if (auto spec = make_spec(*found.family, found.model, found.line, found.id))
        out.spec = std::move(*spec);
    return out;
}

std::string Walk::name_of(const Patient& patient)
{
    return patient.joint.empty() ? fmt::format("id {}", patient.id)
                                 : fmt::format("id {} ({})", patient.id, patient.joint);
}

std::string Walk::names_of(std::span<Patient* const> patients)
{
    if (patients.size() == 1)
        return name_of(*patients.front());
    std::vector<int> ids;
    for (const auto* patient : patients)
        ids.push_back(patient->id);
    return fmt::format("ids {}", fmt::join(ids, ", "));
}

std::expected<std::optional<Look>, Error> Walk::read(const wire::Request& plain, Duration wait)
{
    auto safe = line->safe_one({&plain, 1});
    if (!safe)
        safe = line->safe_one(ways_to_send(*family, plain));
    if (!safe)
        return std::nullopt;
    auto look = line->look(*safe, *family, wait);
    if (!look)
        return std::unexpected(look.error());
    return std::move(*look);
}

std::expected<bool, Error> Walk::answers(const Family& of, int id, const DeviceSpec* spec, Duration wait)
{
    constexpr int tries = 2;
    for (int i = 0; i < tries; ++i) {
        auto request = line->safe_one(ways_to_ask(of, id));
        if (!request)
            return false;
        if (spec != nullptr)
            request->options = options_of(*spec);
        const auto look = line->look(*request, of, wait);
        if (!look)
            return std::unexpected(look.error());
        if (look->reply)
            return true;
    }
    return false;
}

std::vector<wire::Request> Walk::state_reads(const Patient& patient) const
{
    if (!patient.spec)
        return {};
    const auto requests = make_driver(*patient.spec)->plan_read(actuator::Depth::full);
    if (!requests)
        return {};
    std::vector<wire::Request> out;
    for (const auto& request : requests->all())
        if (request.message->info.access == wire::Access::read)
            out.push_back(request);
    return out;
}

} // namespace sinew::diagnosis
