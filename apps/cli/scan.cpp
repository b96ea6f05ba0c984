#include "apps/cli/exit_codes.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/session.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/diagnosis/scanner.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using diagnosis::expected_time;
using diagnosis::Found;
using diagnosis::Pass;
using diagnosis::ScanPlan;

std::expected<wire::Range, Error> ids_from(std::string_view word)
{
    const auto dash = word.find('-');
    const auto low = to_integer(word.substr(0, dash));
    const auto high = dash == std::string_view::npos ? low : to_integer(word.substr(dash + 1));
    if (!low || !high || *low < 0 || *high < *low || *high > 255)
        return fail(Errc::bad_argument, fmt::format("--ids takes one id or a range such as 1-20, not '{}'", word));
    return wire::Range{*low, *high};
}

std::expected<ScanPlan, Error> plan_from(const Words& words)
{
    ScanPlan plan{.all = words.has("--all")};
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        plan.families = {*family};
    }
    const auto rate = words.number("--baud", 1, 20'000'000);
    if (!rate)
        return std::unexpected(rate.error());
    if (*rate)
        plan.bit_rate = static_cast<std::uint32_t>(**rate);
    if (const auto word = words.text("--ids")) {
        const auto ids = ids_from(*word);
        if (!ids)
            return std::unexpected(ids.error());
        plan.ids = *ids;
        for (const auto* family : plan.families)
            if (ids->low > family->ids.high || ids->high < family->ids.low)
                return fail(Errc::bad_id, fmt::format("ids {} are outside the ids of {}: {} … {}", *word, family->name,
                                                      family->ids.low, family->ids.high));
    }
    return plan;
}

/// The rate to open a port with that must be given one: that of the plan, or of the first family.
std::string link_to_open(const std::string& word, const ScanPlan& plan)
{
    const auto* family = plan.families.empty() ? find_family("sam") : plan.families.front();
    return with_bit_rate(word, *family, plan.bit_rate.value_or(0));
}

std::string time_text(Duration time)
{
    const double s = seconds(time);
    return s < 90.0 ? fmt::format("{} s", static_cast<int>(std::ceil(s)))
                    : fmt::format("{:.0f} min", std::ceil(s / 60.0));
}

std::string rate_text(std::uint32_t rate)
{
    return rate != 0 ? fmt::format("{} baud", rate) : "the rate of the link";
}

/// Places are rates here, whatever the family.
std::size_t rates_of(std::span<const Pass> passes)
{
    std::vector<std::uint32_t> rates;
    for (const auto& pass : passes)
        if (std::ranges::find(rates, pass.bit_rate) == rates.end())
            rates.push_back(pass.bit_rate);
    return rates.size();
}

void announce(std::span<const Pass> passes, bool all)
{
    const auto likely = diagnosis::likely_places(passes);
    const auto rates = rates_of(passes);
    if (likely.size() == passes.size() || rates == 1 || all)
        fmt::print(stderr, "Looking at {}: up to {}.\n",
                   rates == 1 ? rate_text(passes.front().bit_rate) : fmt::format("{} bit rates", rates),
                   time_text(expected_time(passes)));
    else
        fmt::print(stderr,
                   "Looking at the likely places first: up to {}; if nobody answers, at {} bit rates, up to {} in "
                   "all.\n",
                   time_text(expected_time(likely)), rates, time_text(expected_time(passes)));
    std::fflush(stderr);
}

void print_found(const Words& words, const std::string& link, const std::vector<Found>& found, bool complete)
{
    if (words.json()) {
        Json devices = Json::array();
        for (const auto& f : found)
            devices.add(Json::object({{"family", f.family->name},
                                      {"bit_rate", f.bit_rate != 0 ? Json(f.bit_rate) : Json()},
                                      {"id", f.id},
                                      {"model", f.model.empty() ? Json() : Json(f.model)},
                                      {"profile", f.line.empty() ? Json() : Json(f.line)},
                                      {"round_trip_s", seconds(f.round_trip)}}));
        print(Json::object({{"link", link}, {"complete", complete}, {"devices", devices}}));
        return;
    }
    Table table({"FAMILY", "BAUD", "ID", "MODEL"});
    for (const auto& f : found)
        table.add({std::string(f.family->name), f.bit_rate != 0 ? std::to_string(f.bit_rate) : "", std::to_string(f.id),
                   f.line.empty() ? f.model : fmt::format("profile {}", f.line)});
    if (!table.empty())
        fmt::print("{}", table.text());
}

std::expected<void, Error> look(diagnosis::Scanner& scanner, const std::vector<Pass>& all, bool go_on,
                                link::Clock& clock, std::vector<Found>& found)
{
    const TimePoint begin = clock.now();
    const Duration expected = expected_time(all);
    const auto at = [&](const Pass& pass, int id) {
        progress(fmt::format("{} {}, id {} of {}, {} found, {} of {}", pass.family->name, rate_text(pass.bit_rate), id,
                             pass.ids.high, found.size(), time_text(clock.now() - begin), time_text(expected)));
    };
    auto done = scanner.sweep(all, go_on, interrupted, at, found);
    end_progress();
    return done;
}

Outcome run(const Words& words)
{
    const auto plan = plan_from(words);
    if (!plan)
        return std::unexpected(plan.error());
    const auto link = link_to_open(*words.text("LINK"), *plan);
    Session session;
    auto opened = session.open(link);
    if (!opened)
        return std::unexpected(opened.error());
    diagnosis::Line line(std::move(*opened), session.clock());
    diagnosis::Scanner scanner(line);
    const auto all = passes(*plan, line.can(), line.bit_rate());
    if (all.empty() && !plan->families.empty() && plan->families.front()->can != line.can())
        return fail(Errc::bad_argument,
                    fmt::format("{} devices are on {}, which {} is not", plan->families.front()->name,
                                plan->families.front()->can ? "CAN" : "serial lines", link));
    if (all.empty())
        return fail(Errc::bad_argument, "no family has such an id");
    announce(all, plan->all);
    std::vector<Found> found;
    const auto done = look(scanner, all, plan->all, session.clock(), found);
    print_found(words, link, found, done && !interrupted());
    if (!done)
        return std::unexpected(done.error());
    if (scanner.left_out() > 0)
        fmt::print(stderr,
                   "{} ids were left out: at another bit rate a question to them would be heard as a command.\n",
                   scanner.left_out());
    if (interrupted()) {
        fmt::print(stderr, "Ended by Ctrl-C: this is what was found until then.\n");
        return exit_interrupted;
    }
    if (found.empty() && record::is_replay(link))
        return fail(Errc::timeout, fmt::format("{} has no answer to what scan asks; sinew replay shows what is in it",
                                               link::parse_uri(link)->target));
    if (found.empty())
        return fail(Errc::timeout,
                    fmt::format("nobody answered on {}; is the device powered, and is the wiring right?", link));
    return exit_done;
}

} // namespace

Verb scan_verb()
{
    return {
        .name = "scan",
        .says = "Find the devices on a link: their family, bit rate and id.",
        .arguments = {{"LINK", "such as serial:/dev/ttyUSB0 or slcan:/dev/ttyACM0"}},
        .options = {{"--family", "F", "look for this family only"},
                    {"--baud", "RATE", "look at this bit rate only"},
                    {"--ids", "A-B", "look at these ids only"},
                    {"--all", "",
                     "go on after the first bit rate at which somebody answers, and give everybody the time that "
                     "the manual allows"},
                    json_option},
        .examples = {{"sinew scan serial:/dev/ttyUSB0", "likely places first"},
                     {"sinew scan serial:/dev/ttyUSB0 --family nuri --baud 9600 --ids 0-20",
                      "seconds instead of minutes"}},
        .run = run,
        .more =
            "Only reads are sent. It begins with the rate in the link, goes on with those of delivery and ends "
            "with all others. Ctrl-C keeps what was found. On CAN only the rate of the link is used, for a frame at "
            "a wrong rate disturbs the whole bus."};
}

} // namespace sinew::cli
