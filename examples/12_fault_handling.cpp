#include "sinew/config/robot_file.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include "sinew/sim/simulator.hpp"
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// A cable falls out while the robot moves, and is put back. What moves stops, what is wrong is one sentence, and the
// way back is `enable`.
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
    const auto clock = sim::clock_for("sim:robots/fault.toml", real, worlds); // for hardware: &real, and no `simulated`
    auto robot = robot::Robot::open("robots/fault.toml", links, **clock, {.simulated = true, .guardian = &*guardian});
    if (!robot)
        return std::puts(to_sentence(robot.error()).c_str()), 1;
    int stops = 0;
    const auto until = (*clock)->now() + 8s;
    while ((*clock)->now() < until) {
        if (const auto on = robot->enable(); !on) { // as long as the cable is out
            std::printf("%5.2f s  not enabled: %s\n", seconds((*clock)->now().time_since_epoch()),
                        to_sentence(on.error()).c_str());
            (*clock)->wait({}, (*clock)->now() + 500ms);
            continue;
        }
        if (const auto set = robot->set("knee", {.mode = robot::Mode::velocity, .velocity_rad_s = 0.5}); !set)
            return std::puts(to_sentence(set.error()).c_str()), 1;
        if (const auto moved = robot->run(10ms, {}, until); !moved) {
            ++stops; // everything has been stopped already
            std::printf("%5.2f s  stopped: %s\n", seconds((*clock)->now().time_since_epoch()),
                        to_sentence(moved.error()).c_str());
        }
    }
    const bool is_well = robot->enabled();
    for (const auto& one : robot->stop())
        std::printf("%s: %s\n", std::string(one.joint).c_str(), std::string(to_word(one.outcome)).c_str());
    return stops == 1 && is_well ? 0 : 1;
}
