#include "bench/sim_bench.hpp"

#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/firmware/devices.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/sim/world.hpp"
#include "sinew/wire/codec.hpp"
#include "tests/support/allocations.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <malloc.h>
#include <memory>
#include <optional>

namespace sinew::bench {
namespace {

using Wall = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int rounds = 7; // the fastest counts: everything else is the machine doing something else
constexpr std::uint32_t bit_rate = 1'500'000;
constexpr std::size_t servos_per_bus = 250;

double seconds_since(Wall::time_point start)
{
    return std::chrono::duration<double>(Wall::now() - start).count();
}

template <class Work>
double best_ns(double operations, Work work)
{
    double best = 1e18;
    for (int round = 0; round < rounds; ++round) {
        const auto start = Wall::now();
        work();
        best = std::min(best, seconds_since(start) * 1e9 / operations);
    }
    return best;
}

sim::PlantParameters loaded_plant()
{
    sim::PlantParameters p = sim::plant_of(*make_spec(*find_family("sam"), "SAM-160EO200", "", 1));
    p.load_inertia_kg_m2 = 0.1;
    p.gravity_torque_nm = 2.0;
    return p;
}

double measure_steps()
{
    constexpr int ticks = 100'000;
    sim::Plant plant(loaded_plant());
    plant.drive_duty(0.5);
    return best_ns(ticks * sim::steps_per_tick, [&] {
        for (int i = 0; i < ticks; ++i)
            plant.run(24.0);
    });
}

double measure_rest()
{
    constexpr int ticks = 1'000'000;
    sim::Plant plant(sim::plant_of(*make_spec(*find_family("sam"), "SAM-160EO200", "", 1)));
    return best_ns(ticks, [&] {
        for (int i = 0; i < ticks; ++i)
            plant.run(24.0);
    });
}

/// A tick of firmware and plant together, after half a second in which it came to rest.
double measure_ticks(const std::optional<wire::Frame>& command)
{
    constexpr int ticks = 200'000;
    const auto spec = *make_spec(*find_family("sam"), "SAM-28", "", 1);
    const double voltage_v = sim::supply_v(spec);
    const auto device = sim::make_device(spec, sim::plant_of(spec));
    device->run(voltage_v);
    if (command)
        (void)device->hear(*command, TimePoint{});
    for (Duration passed{}; passed < 500ms; passed += sim::tick)
        device->run(voltage_v);
    return best_ns(ticks, [&] {
        for (int i = 0; i < ticks; ++i)
            device->run(voltage_v);
    });
}

double measure_idle_ticks()
{
    return measure_ticks({});
}

double measure_holding_ticks()
{
    return measure_ticks(*wire::encode_request(1, sam::PositionControl{1500}));
}

/// A host that only counts.
struct Ear final : sim::SerialHost {
    std::uint32_t bit_rate() const override { return bench::bit_rate; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint) override { heard += bytes.size(); }
    std::size_t heard = 0;
};

double measure_exchanges()
{
    constexpr int devices = 31;
    constexpr int exchanges = 100'000;
    std::vector<std::unique_ptr<sim::Device>> all;
    sim::SerialWire wire(sim::Duplex::full);
    Ear ear;
    wire.connect(&ear);
    for (int id = 0; id < devices; ++id) {
        auto spec = *make_spec(*find_family("sam"), "SAM-28", "", id);
        all.push_back(sim::make_device(spec, sim::plant_of(spec)));
        all.back()->run(sim::supply_v(spec));
        wire.attach(*all.back());
    }
    std::vector<wire::Frame> requests;
    for (int id = 0; id < devices; ++id)
        requests.push_back(*wire::encode_request(id, sam::QuickReadStatus{}));
    TimePoint now{};
    return best_ns(exchanges, [&] {
        for (int i = 0; i < exchanges; ++i) {
            wire.host_sends(requests[static_cast<std::size_t>(i % devices)].bytes(), bit_rate, now);
            now += 300us;
            wire.run_until(now);
        }
    });
}

std::string robot_text(std::size_t servos)
{
    std::string text = "version = 1\n";
    for (std::size_t i = 0; i < servos; ++i) {
        const std::size_t bus = i / servos_per_bus;
        if (i % servos_per_bus == 0)
            text += fmt::format("[bus.b{}]\nfamily = \"sam\"\nbit_rate = {}\n", bus, bit_rate);
        text += fmt::format("[joint.j{}]\nbus = \"b{}\"\nid = {}\nmodel = \"SAM-28\"\n", i, bus, i % servos_per_bus);
    }
    return text;
}

/// Polls every bus without a pause: a position command to every tenth servo, else the status.
WorldResult measure_world(std::size_t servos, double simulated_s)
{
    const auto file = *config::parse_robot_file(robot_text(servos), "bench.toml");
    const auto before = mallinfo2().uordblks;
    const auto world = *sim::World::make(file);
    WorldResult out{.servos = servos, .simulated_s = simulated_s};
    out.bytes_per_servo = static_cast<double>(mallinfo2().uordblks - before) / static_cast<double>(servos);

    std::vector<Ear> ears(world->buses().size());
    for (std::size_t bus = 0; bus < ears.size(); ++bus)
        std::get<sim::SerialWire>(world->buses()[bus].wire).connect(&ears[bus]);
    const std::size_t on_bus = std::min(servos, servos_per_bus);
    std::vector<wire::Frame> reads;
    std::vector<wire::Frame> moves[2];
    for (std::size_t id = 0; id < on_bus; ++id) {
        reads.push_back(*wire::encode_request(static_cast<int>(id), sam::ReadCurrentPosition{}));
        moves[0].push_back(*wire::encode_request(static_cast<int>(id), sam::PositionControl{1500}));
        moves[1].push_back(*wire::encode_request(static_cast<int>(id), sam::PositionControl{2500}));
    }
    constexpr auto period = 300us; // request, response time and answer of a standard read
    const auto steps = static_cast<std::size_t>(simulated_s / seconds(period));
    const auto allocations = support::allocations();
    const auto start = Wall::now();
    TimePoint now{};
    for (std::size_t step = 0; step < steps; ++step) {
        const std::size_t id = step % on_bus;
        const bool moves_now = step / on_bus % 10 == 0;
        const auto& frame = moves_now ? moves[step / on_bus / 10 % 2][id] : reads[id];
        for (sim::WorldBus& bus : world->buses())
            std::get<sim::SerialWire>(bus.wire).host_sends(frame.bytes(), bit_rate, now);
        now += period;
        world->advance(now);
    }
    out.wall_s = seconds_since(start);
    out.allocations = static_cast<double>(support::allocations() - allocations);
    for (const Ear& ear : ears)
        out.exchanges += ear.heard / 2;
    return out;
}

} // namespace

SimResult measure_simulator(bool hour)
{
    SimResult out;
    const auto add = [&](std::string name, double (*measure)()) {
        Cost cost{.name = std::move(name)};
        cost.ns = measure();
        cost.again_ns = measure();
        out.costs.push_back(std::move(cost));
    };
    add("physics, a step of a shaft that turns", measure_steps);
    add("physics, a tick (10 steps) of one that rests", measure_rest);
    add("firmware, a tick of a servo without torque", measure_idle_ticks);
    add("firmware, a tick of a servo that holds", measure_holding_ticks);
    add("firmware and wire, an exchange, 31 on the wire", measure_exchanges);
    for (const auto& [servos, simulated_s] : {std::pair{1U, 100.0}, {31U, 20.0}, {254U, 4.0}, {2000U, 2.0}}) {
        WorldResult world = measure_world(servos, simulated_s);
        world.wall_again_s = measure_world(servos, simulated_s).wall_s;
        out.worlds.push_back(world);
    }
    if (hour)
        out.worlds.push_back(measure_world(31, 3600.0));
    return out;
}

} // namespace sinew::bench
