#include "sinew/diagnosis/probes.hpp"
#include "sinew/diagnosis/walk.hpp"
#include "sinew/family/drivers.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::diagnosis {
namespace {

using namespace std::chrono_literals;

// ---- health ----

void judge(Walk& walk, const Patient& patient, const actuator::State& state)
{
    const auto who = Walk::name_of(patient);
    if (const auto* sam = std::get_if<sam::Spec>(&*patient.spec); sam != nullptr && state.voltage_v) {
        const auto& limits = sam->model->ratings;
        const auto evidence = fmt::format("{} has {:.1f} V; {} takes {:g} to {:g} V", who, *state.voltage_v,
                                          sam->model->name, limits.voltage_min_v, limits.voltage_max_v);
        if (*state.voltage_v < limits.voltage_min_v)
            walk.add(patient, "low-voltage", evidence);
        else if (*state.voltage_v > limits.voltage_max_v)
            walk.add(patient, "high-voltage", evidence);
    }
    if (!state.faults || !state.faults->any())
        return;
    using enum actuator::Fault;
    const auto temperature = state.temperature_c ? fmt::format(" at {:.0f} degC", *state.temperature_c) : "";
    if (state.faults->has(low_voltage))
        walk.add(patient, "low-voltage",
                 fmt::format("{} reports low voltage{}", who,
                             state.voltage_v ? fmt::format(" and {:.1f} V", *state.voltage_v) : ""));
    // The vendor's tool has a limit of 100 degC; what is so much cooler has cooled down.
    constexpr double cool_c = 70.0;
    const bool is_cool = state.temperature_c && *state.temperature_c < cool_c;
    if (state.faults->has(high_voltage))
        walk.add(patient, "high-voltage", fmt::format("{} reports high voltage", who));
    if (state.faults->has(over_temperature) || state.faults->has(driver_over_temperature))
        walk.add(patient, is_cool ? "latched-over-temperature" : "over-temperature",
                 fmt::format("{} reports over-temperature{}", who, temperature));
    for (const auto fault : {over_current, short_circuit, stall, input_lost})
        if (state.faults->has(fault))
            walk.add(patient, "device-fault", fmt::format("{} reports {}", who, to_word(fault)));
    if (state.faults->has(unexplained))
        walk.add(patient, "unexplained-fault", fmt::format("{} reports 0x{:02X}", who, state.raw_faults));
}

std::expected<bool, Error> read_state(Walk& walk, const Patient& patient, actuator::State& state)
{
    const auto driver = make_driver(*patient.spec);
    constexpr int tries = 3;
    for (const auto& request : walk.state_reads(patient)) {
        bool done = false;
        for (int i = 0; i < tries && !done; ++i) {
            const auto look = walk.read(request, walk.patience());
            if (!look)
                return std::unexpected(look.error());
            if (!*look) {
                done = true; // it cannot be asked without harm: not known is not wrong
                continue;
            }
            done =
                (*look)->reply && driver->absorb(request, *(*look)->reply, walk.line->clock().now(), state).has_value();
        }
        if (!done)
            return false;
    }
    return true;
}

// ---- round trips ----

struct Trips {
    std::vector<Duration> all;
    Duration least_excess = Duration::max();
    int asked = 0, lost = 0, wrong = 0;

    Duration at(double share)
    {
        std::ranges::sort(all);
        const auto index = static_cast<std::size_t>(share * static_cast<double>(all.size() - 1));
        return all[index];
    }
};

double ms(Duration d)
{
    return seconds(d) * 1e3;
}

std::expected<void, Error> measure(Walk& walk, const Patient& patient, int count, Trips& trips)
{
    for (int i = 0; i < count && !walk.stopped(); ++i) {
        auto request = walk.line->safe_one(ways_to_ask(*walk.family, patient.id));
        if (!request)
            return {};
        if (patient.spec) {
            request->options = options_of(*patient.spec);
            request->response_time = response_time_of(*patient.spec);
        }
        const auto look = walk.line->look(*request, *walk.family, walk.patience());
        if (!look)
            return std::unexpected(look.error());
        ++trips.asked;
        trips.wrong += look->noise ? 1 : 0;
        if (!look->reply) {
            trips.lost += look->noise ? 0 : 1;
            continue;
        }
        trips.all.push_back(look->round_trip);
        trips.least_excess = std::min(trips.least_excess, look->excess);
    }
    return {};
}

} // namespace

Checked check_health(Walk& walk)
{
    const auto before = walk.count();
    std::string supply;
    for (const auto* patient : walk.readable()) {
        if (!patient->spec)
            continue;
        walk.progress(fmt::format("reading the state of {}", Walk::name_of(*patient)));
        actuator::State state;
        const auto complete = read_state(walk, *patient, state);
        if (!complete)
            return std::unexpected(complete.error());
        if (!*complete)
            walk.add(*patient, "unreadable",
                     fmt::format("{} does not answer all reads of its state", Walk::name_of(*patient)));
        judge(walk, *patient, state);
        if (state.voltage_v && supply.empty())
            supply = fmt::format("{:.1f} V at {}", *state.voltage_v, Walk::name_of(*patient));
    }
    if (!walk.readable().empty() && walk.count() == before)
        walk.fine("health", supply.empty() ? "no faults" : fmt::format("no faults; {}", supply));
    return {};
}

Checked check_round_trips(Walk& walk)
{
    const auto there = walk.readable();
    if (there.empty())
        return {};
    constexpr int in_all = 160, least = 8, most = 40;
    const int each = std::clamp(in_all / static_cast<int>(there.size()), least, most);
    Trips trips;
    for (const auto* patient : there) {
        walk.progress(fmt::format("measuring {}", Walk::name_of(*patient)));
        if (auto done = measure(walk, *patient, each, trips); !done)
            return done;
    }
    if (trips.asked == 0)
        return {};
    const int bad = trips.lost + trips.wrong;
    const auto times = trips.all.empty() ? std::string("no answer at all")
                                         : fmt::format("round trip {:.2f} ms, 99 % within {:.2f} ms, longest {:.2f} ms",
                                                       ms(trips.at(0.5)), ms(trips.at(0.99)), ms(trips.at(1.0)));
    const auto counts = fmt::format("{} reads, {} lost, {} garbled; {}", trips.asked, trips.lost, trips.wrong, times);
    constexpr double few = 0.005, many = 0.1;
    const double share = static_cast<double>(bad) / trips.asked;
    // Less than the timer of any adapter, more than what a busy host takes every time.
    constexpr Duration slow = 5ms;
    if (!trips.all.empty() && trips.least_excess >= slow && !walk.has("slow-adapter"))
        walk.add("slow-adapter", fmt::format("every answer comes {:.1f} ms later than wire and device need, or more",
                                             ms(trips.least_excess)));
    if (share > few)
        walk.add("lossy-line", counts).severity = share >= many ? Severity::error : Severity::warning;
    else
        walk.fine("round-trips", counts);
    return {};
}

} // namespace sinew::diagnosis
