#include "apps/cli/bus_target.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/scanning.hpp"
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

std::expected<void, Error> check_ids(const Words& words, const ScanPlan& plan)
{
    const auto word = words.text("--ids");
    for (const auto* family : plan.families)
        if (word && (plan.ids->low > family->ids.high || plan.ids->high < family->ids.low))
            return fail(Errc::bad_id, fmt::format("ids {} are outside the ids of {}: {} … {}", *word, family->name,
                                                  family->ids.low, family->ids.high));
    return {};
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
    }
    if (auto fine = check_ids(words, plan); !fine)
        return std::unexpected(fine.error());
    return plan;
}

/// Where to look, and for whom.
struct Place {
    std::string bus; ///< of the robot file; empty: a link alone
    std::string link;
    ScanPlan plan;
};

/// One bus of a robot file, or all.
std::expected<std::vector<BusTarget>, Error> buses_from(const Words& words)
{
    const auto word = words.text("BUS");
    if (word && !is_robot_file(*word)) {
        auto one = bus_target(words);
        return one ? std::expected<std::vector<BusTarget>, Error>({std::move(*one)}) : std::unexpected(one.error());
    }
    const auto path = word ? word : robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, "what is to be looked at? Name a link, such as serial:/dev/ttyUSB0, or a robot "
                                        "file, such as --robot arm.toml");
    return robot_buses(words, *path);
}

std::expected<std::vector<Place>, Error> places_from(const Words& words)
{
    auto plan = plan_from(words);
    if (!plan)
        return std::unexpected(plan.error());
    const std::string word = words.text("BUS").value_or("");
    if (is_link(word) && !is_robot_file(word)) {
        if (auto fine = no_sim_for(words, word); !fine)
            return std::unexpected(fine.error());
        return std::vector{Place{.link = link_to_open(word, *plan), .plan = *plan}};
    }
    const auto buses = buses_from(words);
    if (!buses)
        return std::unexpected(buses.error());
    std::vector<Place> out;
    for (const auto& bus : *buses) {
        plan->families = {bus.family};
        if (auto fine = check_ids(words, *plan); !fine)
            return std::unexpected(fine.error());
        out.push_back({.bus = bus.name, .link = bus.link, .plan = *plan});
    }
    return out;
}

void print_found(const Words& words, const Place& place, const std::vector<Found>& found, bool complete)
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
        print_line(Json::object({{"bus", place.bus.empty() ? Json() : Json(place.bus)},
                                 {"link", place.link},
                                 {"complete", complete},
                                 {"devices", devices}}));
        return;
    }
    Table table({"FAMILY", "BAUD", "ID", "MODEL"});
    for (const auto& f : found)
        table.add({std::string(f.family->name), f.bit_rate != 0 ? std::to_string(f.bit_rate) : "", std::to_string(f.id),
                   f.line.empty() ? f.model : fmt::format("profile {}", f.line)});
    if (!table.empty())
        fmt::print("{}", table.text());
}

Outcome look_at(const Words& words, const Place& place)
{
    if (!words.json() && !place.bus.empty()) {
        fmt::print("{}\n", bold(fmt::format("{}  {}", place.bus, place.link)));
        std::fflush(stdout);
    }
    std::vector<Found> found;
    const auto left_out = look_for_devices(place.link, place.plan, found);
    if (!left_out && found.empty())
        return std::unexpected(left_out.error());
    print_found(words, place, found, left_out && !interrupted());
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
        return nobody_answered(place.link);
    return exit_done;
}

/// A bus that fails does not hide those that come after it; the first one says how all of it ends.
Outcome run(const Words& words)
{
    const auto places = places_from(words);
    if (!places)
        return std::unexpected(places.error());
    if (places->size() == 1)
        return look_at(words, places->front());
    int first = exit_done;
    for (const auto& place : *places) {
        const auto done = look_at(words, place);
        if (interrupted())
            return exit_interrupted;
        if (!done)
            fmt::print(stderr, "sinew: bus {}: {}\n", place.bus, to_sentence(done.error()));
        if (first == exit_done)
            first = done ? *done : exit_code(done.error().code);
    }
    return first;
}

} // namespace

Verb scan_verb()
{
    return {
        .name = "scan",
        .says = "Find the devices on a link, or on all buses of a robot: their family, bit rate and id.",
        .arguments = {{"BUS",
                       "a link such as serial:/dev/ttyUSB0 or slcan:/dev/ttyACM0, the name of a bus with --robot, or a "
                       "robot file; without it all buses of --robot",
                       false}},
        .options = {robot_option,
                    sim_option,
                    link_option,
                    {"--family", "F", "look for this family only; with a link"},
                    {"--baud", "RATE", "look at this bit rate only"},
                    {"--ids", "A-B", "look at these ids only"},
                    {"--all", "",
                     "go on after the first bit rate at which somebody answers, and give everybody the time that "
                     "the manual allows"},
                    {"--json", "", "print one object for each bus"}},
        .examples = {{"sinew scan serial:/dev/ttyUSB0", "likely places first"},
                     {"sinew scan serial:/dev/ttyUSB0 --family nuri --baud 9600 --ids 0-20",
                      "seconds instead of minutes"},
                     {"sinew scan --robot arm.toml", "its buses one after the other"},
                     {"sinew scan robots/demo.toml --sim", "the same, simulated"}},
        .run = run,
        .more =
            "Only reads are sent. It begins with the rate in the link, goes on with those of delivery and ends "
            "with all others. Ctrl-C keeps what was found. On CAN only the rate of the link is used, for a frame at "
            "a wrong rate disturbs the whole bus. On the buses of a robot file it looks for the family that the file "
            "says; one on which nobody answers does not keep it from the next."};
}

} // namespace sinew::cli
