#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/link_report.hpp"
#include "apps/cli/measure.hpp"
#include "apps/cli/names.hpp"
#include "apps/cli/present.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// What the wire allows for the frames of this bus: without stuff bits, with all, and with those that were seen.
struct Allowed {
    Duration shortest{}, longest{}, seen{};
    double utilisation = 0.0; ///< share of the time in which there are bits on the wire, at most
    std::size_t exchanges = 0;

    double per_s(Duration cycle) const
    {
        return cycle > Duration{} ? static_cast<double>(exchanges) / seconds(cycle) : 0.0;
    }
};

Allowed allowed(const bus::Line& line, const AdapterPort& port, std::span<const Step> steps,
                std::span<const bus::ExchangeBits> frames)
{
    const auto requests = requests_of(steps);
    const Duration least = time_on_port(port, requests);
    Allowed out{.shortest = std::max(least, bus::predict_cycle(line, requests, bus::Stuffing::least)),
                .longest = std::max(least, bus::predict_cycle(line, requests)),
                .seen = std::max(least, bus::predict_cycle(line, requests, frames)),
                .exchanges = steps.size()};
    std::int64_t bits = 0;
    for (std::size_t i = 0; i < requests.size(); ++i)
        bits += frames[i].request + bus::reply_count(requests[i]) * frames[i].reply;
    const double most = static_cast<double>(line.bit_rate) * seconds(out.seen);
    out.utilisation = most > 0.0 ? static_cast<double>(bits) / most : 0.0;
    return out;
}

double utilisation(const Measured& measured, std::uint32_t bit_rate)
{
    const double most = static_cast<double>(bit_rate) * seconds(measured.time);
    return most > 0.0 ? static_cast<double>(measured.bits) / most : 0.0;
}

double per_s(std::uint64_t count, Duration time)
{
    return time > Duration{} ? static_cast<double>(count) / seconds(time) : 0.0;
}

Json to_json(const BusTarget& target, const bus::Line& line, std::span<const Step> steps, const Allowed& wire,
             const Measured& measured, const link::Report& adapter)
{
    const auto& trips = measured.round_trips;
    const double exchanges = per_s(measured.exchanges, measured.time);
    Json messages = Json::array();
    for (const auto& step : steps)
        messages.add(Json::object({{"joint", step.joint}, {"message", step.request.message->name()}}));
    return Json::object(
        {{"bus", target.name},
         {"link", target.link},
         {"family", target.family->name},
         {"bit_rate", line.bit_rate},
         {"cycle", std::move(messages)},
         {"predicted", Json::object({{"exchanges_per_s", wire.per_s(wire.seen)},
                                     {"exchanges_per_s_least", wire.per_s(wire.longest)},
                                     {"exchanges_per_s_most", wire.per_s(wire.shortest)},
                                     {"utilisation", wire.utilisation}})},
         {"measured", Json::object({{"time_s", seconds(measured.time)},
                                    {"exchanges", static_cast<std::int64_t>(measured.exchanges)},
                                    {"exchanges_per_s", exchanges},
                                    {"cycles_per_s", per_s(measured.cycles, measured.time)},
                                    {"utilisation", utilisation(measured, line.bit_rate)},
                                    {"round_trip_s", Json::object({{"p50", seconds(trips.at(0.5))},
                                                                   {"p90", seconds(trips.at(0.9))},
                                                                   {"p99", seconds(trips.at(0.99))},
                                                                   {"p999", seconds(trips.at(0.999))},
                                                                   {"longest", seconds(trips.longest())}})},
                                    {"losses", static_cast<std::int64_t>(measured.losses)},
                                    {"retries", static_cast<std::int64_t>(measured.counters.retries)},
                                    {"late", static_cast<std::int64_t>(measured.counters.late)},
                                    {"strays", static_cast<std::int64_t>(measured.counters.strays)},
                                    {"quarantines", static_cast<std::int64_t>(measured.counters.quarantines)}})},
         {"share_of_predicted", wire.per_s(wire.seen) > 0.0 ? Json(exchanges / wire.per_s(wire.seen)) : Json()},
         {"adapter", report_json(adapter)}});
}

void print_text(const BusTarget& target, const bus::Line& line, const Allowed& wire, const Measured& measured,
                const link::Report& adapter)
{
    const bool known = line.bit_rate != 0;
    fmt::print("{}  {}, {}, {} {} a cycle, {:.3g} s\n", bold(target.name), target.family->name,
               known ? fmt::format("{} bps", line.bit_rate) : "bit rate not known", wire.exchanges,
               wire.exchanges == 1 ? "exchange" : "exchanges", seconds(measured.time));
    if (const auto words = link::to_words(adapter.settings); !words.empty())
        fmt::print("  {}\n", wrap(words, 2, columns()));
    Table table({"FIGURE", "PREDICTED", "MEASURED"});
    const auto row = [&](std::string_view figure, const std::string& predicted, const std::string& found) {
        table.add({std::string(figure), known ? predicted : "", found});
    };
    const double exchanges = per_s(measured.exchanges, measured.time);
    row("exchanges per second",
        line.can ? fmt::format("{:.1f} ({:.0f} to {:.0f})", wire.per_s(wire.seen), wire.per_s(wire.longest),
                               wire.per_s(wire.shortest))
                 : fmt::format("{:.1f}", wire.per_s(wire.seen)),
        fmt::format("{:.1f}", exchanges));
    row("cycles per second", fmt::format("{:.1f}", wire.per_s(wire.seen) / static_cast<double>(wire.exchanges)),
        fmt::format("{:.1f}", per_s(measured.cycles, measured.time)));
    row("utilisation", fmt::format("{:.1f} %", 100.0 * wire.utilisation),
        known ? fmt::format("{:.1f} %", 100.0 * utilisation(measured, line.bit_rate)) : "");
    for (const auto& [name, share] : {std::pair{"round trip, median", 0.5},
                                      {"round trip, 99 %", 0.99},
                                      {"round trip, 99.9 %", 0.999},
                                      {"round trip, longest", 1.0}})
        row(name, "", fmt::format("{:.1f} us", seconds(measured.round_trips.at(share)) * 1e6));
    row("without an answer", "0", std::to_string(measured.losses));
    row("retries", "0", std::to_string(measured.counters.retries));
    row("late answers", "0", std::to_string(measured.counters.late));
    row(line.can ? "stray frames" : "stray bytes", "0", std::to_string(measured.counters.strays));
    for (const auto& tally : adapter.tallies)
        if (tally.means != link::Tally::Means::nothing || tally.count != 0)
            row(tally.says, "0", std::to_string(tally.count));
    fmt::print("{}", table.text(2));
    if (!known && !record::is_replay(target.link))
        fmt::print(stderr, "The bit rate behind this link is not known; baud=RATE in the link lets it be predicted.\n");
}

/// What is read from each device: its motion, or the message that was named.
std::expected<std::vector<Step>, Error> steps_for(const Words& words, const Family& family,
                                                  std::span<const Device> devices, std::vector<std::string>& notes)
{
    const auto name = words.text("--message");
    if (!name) {
        auto plan = forecast(family, devices, 0);
        notes = std::move(plan.notes);
        return std::move(plan.look);
    }
    std::vector<Step> out;
    for (const auto& device : devices) {
        const auto message = message_named(family, device.line(), *name);
        if (!message)
            return std::unexpected(message.error());
        if ((*message)->info.access != wire::Access::read || !asks_nothing(device, **message))
            return fail(Errc::bad_argument, fmt::format("a measurement repeats its message thousands of times, so it "
                                                        "takes one that only reads and needs no values; {} is none",
                                                        *name));
        const auto asked = request(device, **message, {});
        if (!asked)
            return std::unexpected(asked.error());
        out.push_back(step_of(device, *asked));
    }
    return out;
}

std::expected<std::optional<record::FileWriter>, Error> capture_file(const Words& words)
{
    const auto path = words.text("--write");
    if (!path)
        return std::nullopt;
    auto file = record::FileWriter::create(*path);
    if (!file)
        return std::unexpected(file.error());
    return std::optional(std::move(*file));
}

Outcome run(const Words& words)
{
    const auto time = words.duration("--measure");
    if (!time)
        return std::unexpected(time.error());
    if (!*time)
        return fail(Errc::bad_argument, "say how long to measure, such as --measure 10s");
    auto target = bus_target(words);
    if (!target)
        return std::unexpected(target.error());
    if (target->devices.empty())
        if (auto found = find_devices(words, *target); !found)
            return std::unexpected(found.error());
    std::vector<std::string> notes;
    // What cannot be right is said before anything is opened.
    if (auto early = steps_for(words, *target->family, target->devices, notes); !early)
        return std::unexpected(early.error());
    Session session;
    bus::Bus* bus = nullptr;
    for (auto& device : target->devices) {
        const auto opened = session.bus_of(device);
        if (!opened)
            return std::unexpected(opened.error());
        bus = *opened;
        if (auto found = find_model(device, *bus); !found)
            return std::unexpected(found.error());
    }
    const auto steps = steps_for(words, *target->family, target->devices, notes);
    if (!steps)
        return std::unexpected(steps.error());
    for (const auto& note : notes)
        fmt::print(stderr, "sinew: {}\n", note);
    if (steps->empty())
        return fail(Errc::unsupported, "there is nothing to read on this bus");
    auto file = capture_file(words);
    if (!file)
        return std::unexpected(file.error());
    const auto measured = measure(session, *bus, *target, *steps, **time, *file ? &**file : nullptr);
    if (!measured)
        return std::unexpected(measured.error());
    const bool is_replay = record::is_replay(target->link);
    // A recording has the times of its wire in it, and its robot file the rate.
    const bus::Line line{.can = target->family->can,
                         .bit_rate = is_replay ? target->bit_rate : bus->link_state().bit_rate};
    const auto wire = allowed(line, adapter_port_of(target->link), *steps, measured->frames);
    const auto adapter = report_of(*bus, target->link);
    if (words.json())
        print(to_json(*target, line, *steps, wire, *measured, adapter));
    else
        print_text(*target, line, wire, *measured, adapter);
    if (measured->over)
        fmt::print(stderr, "The recording has no more to tell than this.\n");
    if (interrupted())
        return exit_interrupted;
    return measured->exchanges == 0 ? exit_no_answer : exit_done;
}

} // namespace

Verb bus_verb()
{
    return {.name = "bus",
            .says = "Read from all devices of a bus as fast as it goes, and show what was measured beside what the "
                    "wire allows.",
            .arguments = {{bus_argument.name, bus_argument.says, false}},
            .options = {robot_option,
                        sim_option,
                        link_option,
                        family_option,
                        {"--id", "N", "the id of a device; once for each; without it those that a scan finds", true},
                        model_option,
                        profile_option,
                        {"--measure", "TIME", "how long, such as 10s"},
                        {"--message", "MESSAGE", "another read than that of the motion"},
                        {"--write", "FILE", "keep the traffic: .log (candump) or .pcapng (Wireshark)"},
                        json_option},
            .examples = {{"sinew bus left --robot arm.toml --measure 10s", "a bus of a robot file"},
                         {"sinew bus sim:robots/demo.toml#legs --measure 1s", "a simulated one, in virtual time"},
                         {"sinew bus slcan:/dev/ttyACM0 --family rmd --id 1 --id 2 --measure 5s", "devices by id"},
                         {"sinew bus serial:/dev/ttyUSB0 --measure 5s", "whoever answers a scan"}},
            .run = run,
            .more =
                "Nothing but reads is sent. The prediction knows the bits and the response times; what is missing "
                "to it is the host's own time and that of its adapter. Below stands what the link tells of itself: "
                "what its "
                "driver gave or refused, and what a CAN adapter or controller refused and lost since it was opened."};
}

} // namespace sinew::cli
