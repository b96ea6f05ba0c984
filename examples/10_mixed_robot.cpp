#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// Three families on three buses of very different speed, in one loop: each bus goes as fast as it can, and no slow one
// holds up a fast one.
int main()
{
    // Stops the motors when this program dies, by Ctrl-C too, or hangs for a second.
    auto guardian = robot::Guardian::start({.patience = 1s});
    if (!guardian)
        return std::puts(to_sentence(guardian.error()).c_str()), 1;
    sim::Worlds worlds;
    link::RealClock real;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    const auto clock = sim::clock_for("sim:robots/demo.toml", real, worlds); // for hardware: &real, and no `simulated`
    auto robot = robot::Robot::open("robots/demo.toml", links, **clock, {.simulated = true, .guardian = &*guardian});
    if (!robot)
        return std::puts(to_sentence(robot.error()).c_str()), 1;
    if (const auto on = robot->enable(); !on)
        return std::puts(to_sentence(on.error()).c_str()), 1;

    std::vector<TimePoint> seen(robot->joints().size());
    std::vector<int> fresh(robot->joints().size());
    const auto ended = robot->run(
        5ms,
        [&](robot::Robot& all) {
            for (std::size_t i = 0; i < fresh.size(); ++i)
                if (const auto at = all.joints()[i].state().position_rad.at(); at != seen[i])
                    seen[i] = at, ++fresh[i];
        },
        (*clock)->now() + 2s);
    for (std::size_t i = 0; i < fresh.size(); ++i) {
        const auto& joint = robot->joints()[i];
        std::printf("%-5s %-15s %5.1f positions a second, the last %.1f ms ago\n", joint.bus().c_str(),
                    joint.name().c_str(), fresh[i] / 2.0, 1e3 * seconds(joint.state().age((*clock)->now())));
    }
    robot->stop();
    return ended ? 0 : 1;
}
