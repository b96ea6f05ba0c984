#include "sinew/sim/real_time.hpp"

#include "sinew/sim/pty_port.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::sim {
namespace {

/// Of a terminal whose program sets none; for a CAN adapter it means nothing.
constexpr std::uint32_t adapter_bit_rate = 115'200;

} // namespace

std::expected<std::unique_ptr<RealTimeSimulator>, Error> RealTimeSimulator::make(const config::RobotFile& file,
                                                                                 link::Clock& clock)
{
    auto world = World::make(file);
    if (!world)
        return std::unexpected(std::move(world.error()));
    std::unique_ptr<RealTimeSimulator> simulator(new RealTimeSimulator(std::move(*world), clock));
    for (WorldBus& bus : simulator->world_->buses()) {
        CanWire* can = std::get_if<CanWire>(&bus.wire);
        auto pty = link::PtyMaster::open(can != nullptr ? adapter_bit_rate : bus.bit_rate, clock);
        if (!pty)
            return std::unexpected(std::move(pty.error()));
        const std::string device = (*pty)->device();
        if (can != nullptr) {
            simulator->links_.push_back(
                {bus.name, bus.family->name, fmt::format("slcan:{}?bitrate={}", device, bus.bit_rate)});
            simulator->ports_.push_back(std::make_unique<PtySlcanPort>(std::move(*pty), *can));
        } else {
            simulator->links_.push_back(
                {bus.name, bus.family->name, fmt::format("serial:{}?baud={}", device, bus.bit_rate)});
            simulator->ports_.push_back(
                std::make_unique<PtySerialPort>(std::move(*pty), std::get<SerialWire>(bus.wire)));
        }
    }
    return simulator;
}

RealTimeSimulator::RealTimeSimulator(std::unique_ptr<World> world, link::Clock& clock)
    : world_(std::move(world)), clock_(&clock), power_on_(clock.now())
{
}

RealTimeSimulator::~RealTimeSimulator() = default;

void RealTimeSimulator::run(const std::atomic<bool>& stop, TimePoint until, Visitor* visitor)
{
    std::vector<link::Handle> handles(ports_.size());
    while (!stop.load(std::memory_order_relaxed)) {
        serve(world_time());
        if (visitor != nullptr)
            visitor->serve();
        const TimePoint now = clock_->now();
        if (now >= until)
            return;
        const TimePoint next = world_->next_event();
        TimePoint deadline = std::min(until, now + idle_step);
        if (next != TimePoint::max())
            deadline = std::min(deadline, power_on_ + (next - TimePoint{}));
        std::ranges::transform(ports_, handles.begin(), [](const auto& port) { return link::Handle{port->handle()}; });
        handles.resize(ports_.size());
        if (visitor != nullptr)
            handles.insert(handles.end(), visitor->handles().begin(), visitor->handles().end());
        clock_->wait(handles, deadline);
    }
}

void RealTimeSimulator::serve(TimePoint now)
{
    if (world_->next_event() < now - late_limit)
        late_.fetch_add(1, std::memory_order_relaxed);
    for (const auto& port : ports_)
        port->refresh();
    world_->advance(now);
    for (const auto& port : ports_) {
        port->take_in(now);
        port->hand_out();
    }
}

} // namespace sinew::sim
