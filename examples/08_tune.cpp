#include "sinew/base/units.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/links.hpp"
#include <algorithm>
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// One step with each pair of gains, which the servo forgets at power-off: how far does it swing beyond the target?
int main()
{
    sim::Worlds worlds;
    link::RealClock clock;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    auto opened = sim::open(links, clock, "sim:robots/step.toml#left", worlds); // or "serial:/dev/ttyUSB0?baud=1500000"
    if (!opened)
        return std::puts(to_sentence(opened.error()).c_str()), 1;
    bus::Bus bus("left", std::move(opened->link), *opened->clock, sam::protocol());

    const auto at = [&]() -> int {
        const auto read = bus.call(3, sam::ReadPrecisePosition{});
        return read ? static_cast<int>(read->position) : -1;
    };
    const auto go = [&](int target, Duration time) { // the furthest on the way there
        int furthest = at();
        if (!bus.send(3, sam::PrecisePositionControl{.target_position = static_cast<unsigned>(target)}))
            return -1;
        for (const auto until = bus.clock().now() + time; bus.clock().now() < until;)
            furthest = std::max(furthest, at());
        return furthest;
    };
    constexpr int start = 101525, step = 16920; // 30 degrees of 0.001773 each
    int tried = 0;
    for (const auto& [p, d] : {std::pair{20, 10}, {40, 10}, {80, 10}, {80, 60}}) {
        if (!bus.send(3, sam::SetRuntimePdGain{.p_gain = std::uint8_t(p), .d_gain = std::uint8_t(d)}))
            return 1;
        go(start, 2s);
        const int furthest = go(start + step, 2s);
        tried += furthest > start;
        std::printf("P %2d D %2d: overshoot %5.1f %%, ends %5.2f deg off\n", p, d,
                    std::max(0.0, 100.0 * (furthest - start - step) / step), 0.001773 * (at() - start - step));
    }
    return tried == 4 ? 0 : 1;
}
