#include "sinew/diagnosis/walk.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

/// Where the chain is broken, if the order of the robot file tells: nobody answers from one place on.
std::optional<std::size_t> break_in(const std::vector<Patient>& patients)
{
    const auto is_gone = [](const Patient& p) { return !p.present && !p.elsewhere && !p.silent(); };
    const auto first = std::ranges::find_if(patients, is_gone);
    const bool is_tail = std::all_of(first, patients.end(), is_gone);
    if (first == patients.begin() || first == patients.end() || !is_tail)
        return std::nullopt;
    return static_cast<std::size_t>(first - patients.begin());
}

void add_missing(Walk& walk)
{
    std::vector<Patient*> gone;
    for (auto* patient : walk.missing())
        if (!patient->elsewhere)
            gone.push_back(patient);
    const bool is_sam = walk.family->name == "sam";
    const std::string also = is_sam ? " A SAM at response level 2 is silent as well." : "";
    if (gone.size() == walk.patients.size()) {
        if (!walk.has("wrong-family"))
            walk.add(
                "no-answer",
                fmt::format("{} {} not answer at any bit rate", Walk::names_of(gone), gone.size() == 1 ? "does" : "do"),
                std::string(kind("no-answer").next) + also);
        return;
    }
    if (const auto place = break_in(walk.patients)) {
        const auto before = Walk::name_of(walk.patients[*place - 1]);
        const auto after = Walk::name_of(walk.patients[*place]);
        walk.add("broken-chain",
                 fmt::format("{} {} not answer; all before {} in the robot file do", Walk::names_of(gone),
                             gone.size() == 1 ? "does" : "do", gone.size() == 1 ? "it" : "them"),
                 fmt::format("Look at the cable from {} to {}, at both plugs, and at the supply of what comes after.{}",
                             before, after, also));
        return;
    }
    for (auto* patient : gone)
        walk.add(*patient, "missing-device", fmt::format("{} does not answer, and others do", Walk::name_of(*patient)));
}

/// Those that nobody expects, at the rate of the line.
Checked look_for_others(Walk& walk)
{
    std::vector<Found> found;
    Scanner scanner(*walk.line);
    const auto rate = walk.line->bit_rate();
    const auto at = [&](const Pass&, int id) {
        walk.progress(fmt::format("looking for others, id {} of {}", id, walk.family->ids.high));
    };
    const Pass all{walk.family, rate, walk.family->ids, false};
    if (auto done = scanner.run(all, [&] { return walk.stopped(); }, at, found); !done)
        return done;
    for (const auto& one : found) {
        if (std::ranges::any_of(walk.patients, [&](const Patient& p) { return p.id == one.id; }))
            continue;
        const bool is_new = one.id == walk.family->default_id;
        walk.patients.push_back(Walk::patient_of(one));
        walk.add(walk.patients.back(), "unexpected-device",
                 fmt::format("id {} answers{}{}", one.id, one.model.empty() ? "" : fmt::format(", a {}", one.model),
                             is_new ? "; that is the id of a device as delivered, or after a reset" : ""));
    }
    return {};
}

} // namespace

Checked check_devices(Walk& walk)
{
    if (walk.patients.empty()) {
        walk.add("no-answer", "nobody answered at likely ids, at no bit rate");
        return {};
    }
    const auto expected = static_cast<std::size_t>(
        std::ranges::count_if(walk.patients, [](const Patient& p) { return p.expected && !p.silent(); }));
    const bool complete = walk.missing().empty();
    const auto found = walk.present().size();
    if (!complete)
        add_missing(walk);
    if (expected != 0 && found != 0)
        if (auto done = look_for_others(walk); !done)
            return done;
    if (complete && found != 0)
        walk.fine("devices", expected != 0
                                 ? fmt::format("all {} of the robot file answer", expected)
                                 : fmt::format("{} {}: {}", found, walk.family->name, Walk::names_of(walk.present())));
    return {};
}

} // namespace sinew::diagnosis
