#include "apps/cli/exit_codes.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/scanning.hpp"
#include "apps/cli/session.hpp"
#include "sinew/base/bytes.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

using diagnosis::Found;
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

Outcome run(const Words& words)
{
    const auto plan = plan_from(words);
    if (!plan)
        return std::unexpected(plan.error());
    const auto link = link_to_open(*words.text("LINK"), *plan);
    std::vector<Found> found;
    const auto left_out = look_for_devices(link, *plan, found);
    if (!left_out && found.empty())
        return std::unexpected(left_out.error());
    print_found(words, link, found, left_out && !interrupted());
    if (!left_out)
        return std::unexpected(left_out.error());
    if (*left_out > 0)
        fmt::print(stderr,
                   "{} ids were left out: at another bit rate a question to them would be heard as a command.\n",
                   *left_out);
    if (interrupted()) {
        fmt::print(stderr, "Ended by Ctrl-C: this is what was found until then.\n");
        return exit_interrupted;
    }
    if (found.empty())
        return nobody_answered(link);
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
