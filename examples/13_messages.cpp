#include "sinew/bus/bus.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;

int main()
{
    sim::Worlds worlds;
    link::RealClock clock;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    auto opened = sim::open(links, clock, "sim:robots/demo.toml#left", worlds); // or "serial:/dev/ttyUSB0?baud=1500000"
    if (!opened)
        return std::puts(to_sentence(opened.error()).c_str()), 1;
    bus::Bus bus("left", std::move(opened->link), *opened->clock, sam::protocol());

    const unsigned target = 152290; // 90 degrees from the middle of a SAM-160, 0.001773 degrees a unit
    auto moved = bus.send(3, sam::PrecisePositionControl{.target_position = target});
    for (unsigned at = 0; moved && at != target;) {
        const auto position = bus.call(3, sam::ReadPrecisePosition{});
        if (!position)
            return std::puts(to_sentence(position.error()).c_str()), 1;
        at = position->position;
    }
    return std::puts(moved ? "arrived" : to_sentence(moved.error()).c_str()), 0;
}
