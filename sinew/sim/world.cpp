#include "sinew/sim/world.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/sim/firmware/devices.hpp"
#include "sinew/sim/firmware/ratings.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::sim {
namespace {

/// SAM talks TTL with a line for each direction; Nuri is RS-485 on one pair.
std::variant<SerialWire, CanWire> wire_of(const Family& family)
{
    if (family.can)
        return CanWire{};
    return SerialWire{family.name == "sam" ? Duplex::full : Duplex::half};
}

/// ASSUMED: cable and power supply of a bus.
constexpr double supply_ohm = 0.05;

std::size_t supply_at(std::vector<Supply>& supplies, double voltage_v)
{
    const auto same = std::ranges::find(supplies, voltage_v, &Supply::nominal_v);
    if (same != supplies.end())
        return static_cast<std::size_t>(same - supplies.begin());
    supplies.emplace_back(voltage_v, supply_ohm);
    return supplies.size() - 1;
}

} // namespace

std::expected<std::unique_ptr<World>, Error> World::make(const config::RobotFile& file)
{
    const auto robot = resolve(file);
    if (!robot)
        return std::unexpected(robot.error());
    std::unique_ptr<World> world(new World);
    for (const config::Bus& bus : file.buses) {
        const Family* family = find_family(bus.family.value); // resolve has checked it
        const auto bit_rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : family->default_bit_rate;
        world->buses_.push_back({bus.name, family, bit_rate, wire_of(*family), {}});
    }
    for (const ResolvedJoint& joint : robot->joints) {
        const auto bus = world->find_bus(joint.bus->name);
        if (!bus)
            return std::unexpected(bus.error());
        auto device = make_device(joint.device, plant_of(joint.device));
        std::visit([&](auto& wire) { wire.attach(*device); }, (*bus)->wire);
        world->inhabitants_.push_back({joint.joint->name, std::move(device),
                                       static_cast<std::size_t>(*bus - world->buses_.data()),
                                       supply_at((*bus)->supplies, supply_v(joint.device))});
    }
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
    for (WorldBus& bus : buses_)
        for (Supply& supply : bus.supplies)
            supply.begin();
    for (Inhabitant& inhabitant : inhabitants_) {
        Supply& supply = buses_[inhabitant.bus].supplies[inhabitant.supply];
        inhabitant.device->run(supply.voltage_v());
        supply.take(inhabitant.device->supply_current_a());
    }
    for (WorldBus& bus : buses_)
        for (Supply& supply : bus.supplies)
            supply.run();
    for (WorldBus& bus : buses_)
        std::visit([](auto& wire) { wire.refresh(); }, bus.wire);
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

Device* World::find_device(std::string_view joint)
{
    const auto found = std::ranges::find(inhabitants_, joint, &Inhabitant::joint);
    return found == inhabitants_.end() ? nullptr : found->device.get();
}

std::expected<Look, Error> World::look(std::string_view joint)
{
    if (const Device* device = find_device(joint))
        return device->look();
    std::vector<std::string_view> names;
    for (const Inhabitant& inhabitant : inhabitants_)
        names.push_back(inhabitant.joint);
    return fail(Errc::unknown_name, fmt::format("there is no joint '{}'{}", joint, did_you_mean(joint, names)));
}

} // namespace sinew::sim
