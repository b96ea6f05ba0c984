#include "sinew/base/units.hpp"
#include "sinew/diagnosis/walk.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

struct Reads {
    int asked = 0;
    int wrong = 0;       ///< something came that is no answer, or more than that
    int silent = 0;      ///< nothing came
    int probes_lost = 0; ///< of as many that every device answers alike
    double bad() const { return asked == 0 ? 0.0 : static_cast<double>(wrong + silent) / asked; }
};

std::expected<Reads, Error> read_again_and_again(Walk& walk, const Patient& patient)
{
    constexpr int rounds = 4;
    Reads out;
    const auto reads = walk.state_reads(patient);
    for (int round = 0; round < rounds && !walk.stopped(); ++round) {
        const auto there =
            walk.answers(*walk.family, patient.id, patient.spec ? &*patient.spec : nullptr, walk.patience());
        if (!there)
            return std::unexpected(there.error());
        out.probes_lost += *there ? 0 : 1;
        for (const auto& request : reads) {
            const auto look = walk.read(request, walk.patience());
            if (!look)
                return std::unexpected(look.error());
            if (!*look)
                continue;
            ++out.asked;
            if ((*look)->noise || (!(*look)->reply && !(*look)->heard.empty()))
                ++out.wrong;
            else if (!(*look)->reply)
                ++out.silent;
        }
    }
    return out;
}

/// A SAM tells its angle in two or three coordinates; where two devices talk at once the bits that both leave high are
/// what arrives, and the coordinates disagree. Nothing where they agree.
std::expected<std::string, Error> contradiction(Walk& walk, const Patient& patient)
{
    const auto* spec = patient.spec ? std::get_if<sam::Spec>(&*patient.spec) : nullptr;
    if (spec == nullptr)
        return std::string{};
    const auto says = walk.call<sam::ReadFirmwareVersion>(patient);
    if (!says)
        return std::unexpected(says.error());
    const auto quick = walk.call<sam::QuickReadStatus>(patient);
    if (!quick)
        return std::unexpected(quick.error());
    const auto standard = walk.call<sam::ReadCurrentPosition>(patient);
    if (!standard)
        return std::unexpected(standard.error());
    const auto again = walk.call<sam::QuickReadStatus>(patient);
    if (!again)
        return std::unexpected(again.error());
    // A shaft that turns is somewhere else at every question.
    if (!*quick || !*standard || !*again || (*quick)->position != (*again)->position)
        return std::string{};
    const auto* said = *says ? sam::find_model((*says)->model_number) : nullptr;
    std::string out;
    for (const auto* model : {spec->model, said}) {
        if (model == nullptr)
            continue;
        const double a = units::deg(model->quick.rad((*quick)->position));
        const double b = units::deg(model->standard.rad((*standard)->position));
        constexpr double tolerance_units = 3.0;
        if (std::abs(a - b) <= tolerance_units * model->quick.deg_per_unit)
            return std::string{};
        out = fmt::format("its position is {:.0f} deg in one reading and {:.0f} deg in another", a, b);
    }
    return out;
}

/// What the others on the line suffer, in the middle.
double usual_bad(const std::vector<Reads>& all, std::size_t but)
{
    std::vector<double> others;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (i != but)
            others.push_back(all[i].bad());
    if (others.empty())
        return 0.0;
    std::ranges::sort(others);
    return others[others.size() / 2];
}

bool is_doubled(const std::vector<Reads>& all, std::size_t which)
{
    constexpr double often = 0.25; // of answers that differ between any two devices
    constexpr double more_than_others = 4.0;
    const Reads& one = all[which];
    if (one.bad() < often || one.bad() < more_than_others * usual_bad(all, which))
        return false;
    // Alone on a bad line: its short answers, alike from both, come through.
    return all.size() > 1 || one.probes_lost == 0;
}

} // namespace

Checked check_duplicates(Walk& walk)
{
    const auto there = walk.present();
    if (there.empty())
        return {};
    std::vector<Reads> reads;
    for (const auto* patient : there) {
        walk.progress(fmt::format("reading {} again and again", Walk::name_of(*patient)));
        auto one = read_again_and_again(walk, *patient);
        if (!one)
            return std::unexpected(one.error());
        reads.push_back(*one);
    }
    bool any = false;
    for (std::size_t i = 0; i < there.size(); ++i) {
        auto why = contradiction(walk, *there[i]);
        if (!why)
            return std::unexpected(why.error());
        const bool garbled = is_doubled(reads, i);
        if (!garbled && why->empty())
            continue;
        any = there[i]->doubled = true;
        walk.add(*there[i], "duplicate-id",
                 garbled ? fmt::format("{} of {} answers of {} are garbled, too long or missing; its pings are not",
                                       reads[i].wrong + reads[i].silent, reads[i].asked, Walk::name_of(*there[i]))
                         : fmt::format("{}: {}", Walk::name_of(*there[i]), *why));
    }
    if (!any)
        walk.fine("duplicates", "every id answers with one voice");
    return {};
}

} // namespace sinew::diagnosis
