#include "sinew/base/units.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;

// Everything that every joint measures. Nothing is enabled, so nothing moves.
int main()
{
    sim::Worlds worlds;
    link::RealClock real;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    const auto clock = sim::clock_for("sim:robots/demo.toml", real, worlds); // for hardware: &real, and no `simulated`
    auto robot = robot::Robot::open("robots/demo.toml", links, **clock, {.simulated = true});
    if (!robot)
        return std::puts(to_sentence(robot.error()).c_str()), 1;
    if (const auto read = robot->read(); !read)
        return std::puts(to_sentence(read.error()).c_str()), 1;

    for (const auto& joint : robot->joints()) {
        const auto& state = joint.state(); // what was not measured is not there
        std::printf("%-15s", joint.name().c_str());
        if (state.position_rad)
            std::printf(" %8.2f deg", units::deg(*state.position_rad));
        if (state.temperature_c)
            std::printf(" %5.1f C", *state.temperature_c);
        if (state.voltage_v)
            std::printf(" %5.1f V", *state.voltage_v);
        std::printf("  %.1f ms ago\n", 1e3 * seconds(state.age(robot->clock().now())));
    }
}
