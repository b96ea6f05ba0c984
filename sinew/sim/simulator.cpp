#include "sinew/sim/simulator.hpp"

#include "sinew/sim/virtual_port.hpp"

namespace sinew::sim {

std::expected<std::unique_ptr<Simulator>, Error> Simulator::make(const config::RobotFile& file)
{
    auto world = World::make(file);
    if (!world)
        return std::unexpected(std::move(world.error()));
    return std::unique_ptr<Simulator>(new Simulator(std::move(*world)));
}

std::expected<std::unique_ptr<Simulator>, Error> Simulator::read(const std::filesystem::path& path)
{
    const auto file = config::read_robot_file(path);
    if (!file)
        return std::unexpected(file.error());
    return make(*file);
}

Simulator::Simulator(std::unique_ptr<World> world) : world_(std::move(world)), clock_(*world_)
{
    for (WorldBus& bus : world_->buses()) {
        if (std::holds_alternative<CanWire>(bus.wire))
            ports_.push_back(std::make_unique<CanPort>(*world_, bus));
        else
            ports_.push_back(std::make_unique<SerialPort>(*world_, bus));
        clock_.watch(*ports_.back());
    }
}

Simulator::~Simulator() = default;

std::expected<VirtualPort*, Error> Simulator::port(std::string_view bus)
{
    const auto found = world_->find_bus(bus);
    if (!found)
        return std::unexpected(found.error());
    return std::ranges::find(ports_, *found, [](const auto& p) { return &p->bus(); })->get();
}

std::expected<link::AnyLink, Error> Simulator::open(std::string_view bus)
{
    const auto found = port(bus);
    return found ? (*found)->open(clock_) : std::unexpected(found.error());
}

bool Simulator::set_plugged(std::string_view bus, bool plugged)
{
    const auto found = port(bus);
    if (found)
        (*found)->set_plugged(plugged);
    return found.has_value();
}

} // namespace sinew::sim
