#include "sinew/sim/real_time.hpp"

#include "sinew/sim/real_port.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::sim {

std::expected<std::unique_ptr<RealTimeSimulator>, Error> RealTimeSimulator::make(const config::RobotFile& file,
                                                                                 link::Clock& clock,
                                                                                 std::span<const Place> places)
{
    auto world = World::make(file);
    if (!world)
        return std::unexpected(std::move(world.error()));
    for (const Place& place : places)
        if (const auto found = (*world)->find_bus(place.bus); !found)
            return std::unexpected(found.error());
    std::unique_ptr<RealTimeSimulator> simulator(new RealTimeSimulator(std::move(*world), clock));
    for (WorldBus& bus : simulator->world_->buses()) {
        const auto place = std::ranges::find(places, bus.name, &Place::bus);
        auto opened = open_port(bus, place == places.end() ? "" : place->uri, clock);
        if (!opened)
            return std::unexpected(std::move(opened.error()));
        simulator->links_.push_back({bus.name, bus.family->name, std::move(opened->link)});
        simulator->ports_.push_back(std::move(opened->port));
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
        if (visitor != nullptr) {
            tell(*visitor);
            visitor->serve();
        }
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

void RealTimeSimulator::tell(Visitor& visitor)
{
    for (std::size_t i = 0; i < ports_.size(); ++i)
        if (const std::string news = ports_[i]->news(); !news.empty())
            visitor.hear(fmt::format("{}: {}", links_[i].bus, news));
}

void RealTimeSimulator::set_tap(const std::function<void(const Passed&)>& tap)
{
    auto link = links_.begin();
    for (const auto& port : ports_) {
        const auto* const bus = &*link++;
        if (!tap) {
            port->set_tap(nullptr);
            continue;
        }
        port->set_tap([tap, bus](wire::Direction direction, std::span<const std::uint8_t> bytes,
                                 const wire::Frame* frame, TimePoint at) {
            tap({.bus = bus, .direction = direction, .bytes = bytes, .frame = frame, .at = at});
        });
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
