#include "sinew/bus/bus.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// A program that the servo runs by itself, also without a host: to and fro between 82 and 172, 266 ms each (the example
// of the manual). It is kept in flash, which wears out, and no device gives it back to be compared: store it once.
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

    sam::WriteMotionData program{.motion_count = 4};
    program.instructions = {{{0x10, 82}, {0x31, 0x0A}, {0x10, 172}, {0x31, 0x0A}}}; // go, wait, go, wait
    const auto kept = bus.call(1, program);
    if (!kept)
        return std::puts(to_sentence(kept.error()).c_str()), 1;
    std::printf("%d instructions kept\n", kept->motion_count);

    unsigned low = ~0U, high = 0;
    for (const auto until = bus.clock().now() + 2s; bus.clock().now() < until;)
        if (const auto at = bus.call(1, sam::ReadPrecisePosition{}))
            low = std::min<unsigned>(low, at->position), high = std::max<unsigned>(high, at->position);
    std::printf("it moves between %u and %u by itself\n", low, high);
    const auto ended = bus.call(1, sam::WriteMotionData{}); // no instruction: it does not run
    return ended && high - low > 10000 ? 0 : 1;
}
