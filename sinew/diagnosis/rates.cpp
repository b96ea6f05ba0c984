#include "sinew/diagnosis/walk.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

/// Looks for those that are missing at all other rates of their family.
Checked look_at_other_rates(Walk& walk)
{
    const auto usual = walk.line->bit_rate();
    std::vector<std::uint32_t> rates;
    for (const auto& rate : walk.family->bit_rates)
        rates.push_back(rate.bps);
    // That of delivery first, then from fast to slow.
    std::ranges::sort(rates, [&](auto a, auto b) {
        const auto first = walk.family->default_bit_rate;
        return (a == first) != (b == first) ? a == first : a > b;
    });
    for (const auto rate : rates) {
        if (rate == usual || walk.stopped())
            continue;
        const auto set = walk.line->set_bit_rate(rate);
        if (!set)
            return std::unexpected(set.error());
        if (!*set)
            continue;
        for (auto* patient : walk.missing()) {
            if (patient->elsewhere)
                continue;
            walk.progress(fmt::format("looking for {} at {} baud", Walk::name_of(*patient), rate));
            const auto there = walk.answers(*walk.family, patient->id, &*patient->spec, Walk::quick(*walk.family));
            if (!there)
                return std::unexpected(there.error());
            if (*there)
                patient->elsewhere = rate;
        }
    }
    const auto back = walk.line->set_bit_rate(usual);
    return back ? Checked{} : std::unexpected(back.error());
}

/// All that works at another rate than it should, by rate; when nobody works at that of the line it goes on there.
Checked add_wrong_rates(Walk& walk)
{
    const auto usual = walk.line->bit_rate();
    std::vector<std::uint32_t> rates;
    for (const auto* patient : walk.missing())
        if (patient->elsewhere && std::ranges::find(rates, *patient->elsewhere) == rates.end())
            rates.push_back(*patient->elsewhere);
    for (const auto rate : rates) {
        std::vector<Patient*> there;
        for (auto* patient : walk.missing())
            if (patient->elsewhere == rate)
                there.push_back(patient);
        const auto evidence = fmt::format("{} {} at {} baud and not at {}", Walk::names_of(there),
                                          there.size() == 1 ? "answers" : "answer", rate, usual);
        const bool all_of_them = there.size() == walk.patients.size();
        const auto next =
            all_of_them
                ? fmt::format("Use baud={} in the link and bit_rate = {} in the robot file.", rate, rate)
                : fmt::format(
                      "Open the link with baud={} and set its rate to {} with `sinew baud`, which writes its flash.",
                      rate, usual);
        if (there.size() == 1)
            walk.add(*there.front(), "wrong-baud", evidence, next);
        else
            walk.add("wrong-baud", evidence, next);
    }
    if (walk.present().empty() && rates.size() == 1) {
        if (const auto set = walk.line->set_bit_rate(rates.front()); !set)
            return std::unexpected(set.error());
        for (auto& patient : walk.patients)
            patient.present = patient.elsewhere == rates.front();
    }
    return {};
}

/// Nobody runs a robot more slowly, and looking there takes its time.
constexpr std::uint32_t slowest_likely = 9600;

/// Whether somebody of another family is there.
Checked look_for_other_families(Walk& walk)
{
    if (walk.line->can())
        return {};
    std::vector<const Family*> others;
    for (const auto* family : families())
        if (!family->can && family != walk.family)
            others.push_back(family);
    const auto usual = walk.line->bit_rate();
    std::vector<Pass> likely;
    for (const auto& pass : passes({.families = others}, false, usual))
        if (pass.likely && (pass.bit_rate == usual || pass.bit_rate >= slowest_likely))
            likely.push_back(pass);
    std::vector<Found> found;
    Scanner scanner(*walk.line);
    const auto at = [&](const Pass& pass, int) {
        walk.progress(fmt::format("looking for {} at {} baud", pass.family->name, pass.bit_rate));
    };
    if (auto done = scanner.sweep(likely, false, [&] { return walk.stopped(); }, at, found); !done)
        return done;
    if (!found.empty())
        walk.add("wrong-family", fmt::format("{} id {} answers at {} baud", found.front().family->name,
                                             found.front().id, found.front().bit_rate));
    const auto back = walk.line->set_bit_rate(usual);
    return back ? Checked{} : std::unexpected(back.error());
}

/// Firmware lines that answer on other identifiers.
Checked look_for_other_lines(Walk& walk)
{
    std::vector<Found> found;
    Scanner scanner(*walk.line);
    const Pass all{walk.family, walk.line->bit_rate(), walk.family->ids, true};
    if (auto done = scanner.run(all, [] { return false; }, [](const Pass&, int) {}, found); !done)
        return done;
    for (const auto& one : found)
        for (auto* patient : walk.missing()) {
            if (patient->id != one.id)
                continue;
            const auto line = one.line.empty() ? walk.family->profiles.front()->name : one.line;
            walk.add(*patient, "wrong-profile",
                     fmt::format("{} answers on the identifiers of {}, and the robot file says {}",
                                 Walk::name_of(*patient), line, line_of(*patient->spec).name),
                     fmt::format("Write profile = \"{}\" for the joint, if the papers of the motor agree.", line));
            patient->present = true;
            if (auto spec = make_spec(*walk.family, model_of(*patient->spec), line, patient->id))
                patient->spec = std::move(*spec);
        }
    return {};
}

Checked look_for_expected(Walk& walk)
{
    for (auto& patient : walk.patients) {
        if (walk.stopped())
            return {};
        if (patient.silent())
            continue;
        walk.progress(fmt::format("asking {}", Walk::name_of(patient)));
        const auto there = walk.answers(*walk.family, patient.id, &*patient.spec, walk.patience());
        if (!there)
            return std::unexpected(there.error());
        patient.present = *there;
    }
    if (walk.missing().empty() || walk.stopped())
        return {};
    if (walk.line->can())
        return look_for_other_lines(walk);
    if (walk.line->bit_rate() == 0)
        return {};
    if (auto done = look_at_other_rates(walk); !done)
        return done;
    if (auto done = add_wrong_rates(walk); !done)
        return done;
    return walk.present().empty() && !walk.has("wrong-baud") ? look_for_other_families(walk) : Checked{};
}

// ---- without a robot file ----

/// Everybody at likely places; where somebody is, everybody.
Checked look_for_anybody(Walk& walk)
{
    const auto usual = walk.line->bit_rate();
    ScanPlan plan;
    if (walk.family != nullptr)
        plan.families = {walk.family};
    std::vector<Pass> places;
    for (const auto& pass : passes(plan, walk.line->can(), usual))
        if (pass.likely || pass.bit_rate == usual || pass.bit_rate == pass.family->default_bit_rate)
            places.push_back(pass);
    const auto at = [&](const Pass& pass, int id) {
        walk.progress(fmt::format("looking for {} at {}, id {}", pass.family->name,
                                  pass.bit_rate != 0 ? fmt::format("{} baud", pass.bit_rate) : "the rate of the link",
                                  id));
    };
    std::vector<Found> found;
    Scanner scanner(*walk.line);
    if (auto done = scanner.sweep(places, false, [&] { return walk.stopped(); }, at, found); !done)
        return done;
    if (found.empty()) {
        const auto back = walk.line->set_bit_rate(usual);
        return back ? Checked{} : std::unexpected(back.error());
    }
    // One conversation is of one family: that of the first.
    walk.family = found.front().family;
    const auto rate = found.front().bit_rate;
    for (const auto& one : found)
        if (one.family == walk.family && one.bit_rate == rate)
            walk.patients.push_back(Walk::patient_of(one));
    const auto set = walk.line->set_bit_rate(rate);
    if (!set)
        return std::unexpected(set.error());
    if (!walk.subject.rate_is_guessed && usual != 0 && rate != usual && !walk.line->can())
        walk.add("wrong-baud",
                 fmt::format("{} answers at {} baud and not at {}", Walk::name_of(walk.patients.front()), rate, usual),
                 fmt::format("Use baud={} in the link.", rate));
    return {};
}

} // namespace

Checked check_bit_rate(Walk& walk)
{
    const bool knows = !walk.subject.expected.empty();
    if (auto done = knows ? look_for_expected(walk) : look_for_anybody(walk); !done)
        return done;
    if (walk.has("wrong-baud") || walk.has("wrong-family") || walk.present().empty())
        return {};
    const auto rate = walk.line->bit_rate();
    walk.fine("bit-rate", rate != 0 ? fmt::format("{} {} at {} bps", Walk::names_of(walk.present()),
                                                  walk.present().size() == 1 ? "answers" : "answer", rate)
                                    : fmt::format("{} answer", Walk::names_of(walk.present())));
    return {};
}

} // namespace sinew::diagnosis
