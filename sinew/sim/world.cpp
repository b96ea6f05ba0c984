#include "sinew/sim/world.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/sim/firmware/devices.hpp"

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
        world->buses_.push_back({bus.name, family, bit_rate, wire_of(*family)});
    }
    for (const ResolvedJoint& joint : robot->joints) {
        auto& device = world->inhabitants_.emplace_back(joint.joint->name, make_device(joint.device)).device;
        device->advance(world->now_);
        const auto bus = world->find_bus(joint.bus->name);
        if (!bus)
            return std::unexpected(bus.error());
        std::visit([&](auto& wire) { wire.attach(*device); }, (*bus)->wire);
    }
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
    for (WorldBus& bus : buses_)
        std::visit([&](auto& wire) { wire.run_until(until); }, bus.wire);
    now_ = until;
}

void World::advance_devices()
{
    for (Inhabitant& inhabitant : inhabitants_)
        inhabitant.device->advance(now_);
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
    if (Device* device = find_device(joint)) {
        device->advance(now_);
        return device->look();
    }
    std::vector<std::string_view> names;
    for (const Inhabitant& inhabitant : inhabitants_)
        names.push_back(inhabitant.joint);
    return fail(Errc::unknown_name, fmt::format("there is no joint '{}'{}", joint, did_you_mean(joint, names)));
}

} // namespace sinew::sim
