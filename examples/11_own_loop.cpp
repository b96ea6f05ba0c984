#include "sinew/base/units.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;
using robot::Mode;
using namespace std::chrono_literals;

// Your own loop: it closes a position loop over the speed of a knee, and each cycle is one exchange on every bus.
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

    robot::Joint& knee = *robot->find("left_knee");
    const double target = units::rad(60.0);
    int cycles = 0;
    for (const auto until = (*clock)->now() + 3s; (*clock)->now() < until; ++cycles) {
        // Where it is now, and not where it was when it was measured.
        const double here = knee.state().position_rad_at((*clock)->now()).value_or(*knee.state().position_rad);
        const double speed = std::clamp(4.0 * (target - here), -2.0, 2.0);
        if (const auto set = knee.set({.mode = Mode::velocity, .velocity_rad_s = speed}); !set)
            return std::puts(to_sentence(set.error()).c_str()), 1;
        if (const auto turn = robot->cycle(); !turn) // the robot is stopped, and this says why
            return std::puts(to_sentence(turn.error()).c_str()), 1;
    }
    std::printf("%d cycles; the knee is at %.2f deg\n", cycles, units::deg(*knee.state().position_rad));
    robot->stop();
    return std::abs(*knee.state().position_rad - target) < units::rad(0.5) ? 0 : 1;
}
