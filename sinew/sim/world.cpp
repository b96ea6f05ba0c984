#include "sinew/sim/world.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/sim/firmware/devices.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/sim/options.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::sim {
namespace {

/// SAM talks TTL with a line for each direction, or RS-485 on one pair, as Nuri does.
std::variant<SerialWire, CanWire> wire_of(const Family& family, const BusOptions& options)
{
    if (family.can)
        return CanWire{};
    SerialWire wire{family.name == "sam" && !options.half_duplex ? Duplex::full : Duplex::half};
    if (options.collision != Collision::by_wire)
        wire.set_contention(options.collision == Collision::garble ? Contention::garble : Contention::wired_and);
    return wire;
}

std::size_t supply_at(std::vector<Supply>& supplies, double voltage_v, double ohm)
{
    const auto same = std::ranges::find(supplies, voltage_v, &Supply::nominal_v);
    if (same != supplies.end())
        return static_cast<std::size_t>(same - supplies.begin());
    supplies.emplace_back(voltage_v, ohm);
    return supplies.size() - 1;
}

} // namespace

std::expected<std::unique_ptr<World>, Error> World::make(const config::RobotFile& file)
{
    const auto robot = resolve(file);
    if (!robot)
        return std::unexpected(robot.error());
    const auto options = world_options_of(file);
    if (!options)
        return std::unexpected(options.error());
    std::unique_ptr<World> world(new World);
    world->file_ = file;
    std::vector<BusOptions> bus_options;
    for (const config::Bus& bus : file.buses) {
        const auto of_bus = bus_options_of(file, bus);
        if (!of_bus)
            return std::unexpected(of_bus.error());
        bus_options.push_back(*of_bus);
        const Family* family = find_family(bus.family.value); // resolve has checked it
        const auto bit_rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : family->default_bit_rate;
        world->buses_.push_back({bus.name, family, bit_rate, wire_of(*family, *of_bus), {}});
        if (auto* serial = std::get_if<SerialWire>(&world->buses_.back().wire))
            serial->host_end() = {.echo = of_bus->echo,
                                  .usb_latency = std::chrono::duration_cast<Duration>(
                                      std::chrono::duration<double>(of_bus->usb_latency_s))};
    }
    for (const ResolvedJoint& joint : robot->joints) {
        const auto bus = world->find_bus(joint.bus->name);
        if (!bus)
            return std::unexpected(bus.error());
        if (bus_options[static_cast<std::size_t>(*bus - world->buses_.data())].half_duplex)
            if (const auto fits = check_half_duplex(file, joint); !fits)
                return std::unexpected(fits.error());
        const auto plant = plant_of(file, *joint.joint, plant_of(joint.device));
        if (!plant)
            return std::unexpected(plant.error());
        auto device = make_device(joint.device, *plant);
        std::visit([&](auto& wire) { wire.attach(*device); }, (*bus)->wire);
        const auto place = static_cast<std::size_t>(*bus - world->buses_.data());
        const BusOptions& supply = bus_options[place];
        const double voltage_v = supply.supply_v > 0.0 ? supply.supply_v : supply_v(joint.device);
        world->inhabitants_.push_back(
            {joint.joint->name, std::move(device), place, supply_at((*bus)->supplies, voltage_v, supply.supply_ohm)});
    }
    for (const config::Section& section : file.faults) {
        const auto fault = fault_of(file, section);
        if (!fault)
            return std::unexpected(fault.error());
        world->inject(*fault);
    }
    // A stream of chance for each wire: what happens on one changes nothing on another.
    for (std::size_t i = 0; i < world->buses_.size(); ++i)
        std::visit([&](auto& wire) { wire.seed(static_cast<std::uint64_t>(options->seed) * 1'000'003 + i); },
                   world->buses_[i].wire);
    world->run_tick(); // power-on
    return world;
}

TimePoint World::next_event() const
{
    TimePoint next = TimePoint::max();
    for (const WorldBus& bus : buses_)
        next = std::min(next, std::visit([](const auto& wire) { return wire.next_event(); }, bus.wire));
    return next;
}

void World::advance(TimePoint until)
{
    if (until < now_)
        return;
    while (next_tick_ <= until) {
        run_wires(next_tick_);
        run_tick();
    }
    run_wires(until);
}

void World::run_wires(TimePoint until)
{
    for (WorldBus& bus : buses_)
        std::visit([&](auto& wire) { wire.run_until(until); }, bus.wire);
    now_ = until;
}

void World::run_tick()
{
    next_tick_ += tick;
    run_faults();
    for (WorldBus& bus : buses_)
        for (Supply& supply : bus.supplies)
            supply.begin();
    for (Inhabitant& inhabitant : inhabitants_) {
        Supply& supply = buses_[inhabitant.bus].supplies[inhabitant.supply];
        inhabitant.device->run(supply.voltage_v());
        supply.take(inhabitant.device->supply_current_a());
    }
    for (WorldBus& bus : buses_)
        std::visit([](auto& wire) { wire.refresh(); }, bus.wire);
    for (WorldBus& bus : buses_)
        for (Supply& supply : bus.supplies)
            supply.run();
}

std::expected<WorldBus*, Error> World::find_bus(std::string_view name)
{
    if (name.empty() && buses_.size() == 1)
        return &buses_.front();
    const auto found = std::ranges::find(buses_, name, &WorldBus::name);
    if (found != buses_.end())
        return &*found;
    std::vector<std::string_view> names;
    for (const WorldBus& bus : buses_)
        names.push_back(bus.name);
    return fail(Errc::link_not_found,
                name.empty() ? fmt::format("which bus? The robot has {}", fmt::join(names, ", "))
                             : fmt::format("there is no bus '{}'; the robot has {}", name, fmt::join(names, ", ")));
}

std::vector<std::string_view> World::joints() const
{
    std::vector<std::string_view> names;
    for (const Inhabitant& inhabitant : inhabitants_)
        names.push_back(inhabitant.joint);
    return names;
}

Device* World::find_device(std::string_view joint)
{
    const auto found = std::ranges::find(inhabitants_, joint, &Inhabitant::joint);
    return found == inhabitants_.end() ? nullptr : found->device.get();
}

std::expected<Look, Error> World::look(std::string_view joint)
{
    if (const Device* device = find_device(joint))
        return device->look();
    return fail(Errc::unknown_name, fmt::format("there is no joint '{}'{}", joint, did_you_mean(joint, joints())));
}

} // namespace sinew::sim
