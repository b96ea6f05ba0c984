#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// Push with a current, and with a torque where the motor's constant is known. A joint that comes to its limit holds.
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
    const auto& can = knee.capabilities();
    const robot::Command push = can.torque ? robot::Command{.mode = robot::Mode::torque, .torque_nm = 0.5}
                                           : robot::Command{.mode = robot::Mode::current, .current_a = 0.5};
    if (!can.torque)
        std::printf("no torque: %s\n", std::string(can.torque.why_not).c_str());
    if (const auto set = knee.set(push); !set)
        return std::puts(to_sentence(set.error()).c_str()), 1;
    const auto ended = robot->wait(1s);
    const auto& state = knee.state();
    std::printf("%.2f A, %.2f rad/s\n", state.current_a.value_or(0.0), state.velocity_rad_s.value_or(0.0));
    for (const auto& incident : robot->incidents())
        std::printf("%s\n", incident.says.c_str());
    robot->stop();
    return ended ? 0 : 1;
}
