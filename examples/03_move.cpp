#include "sinew/base/units.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cmath>
#include <cstdio>

using namespace sinew;
using robot::Mode;

int main()
{
    // Stops the motors when this program dies, by Ctrl-C too, or hangs for a second.
    auto guardian = robot::Guardian::start({.patience = std::chrono::seconds(1)});
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
    if (auto on = robot->enable(); !on) // everything holds where it is
        return std::puts(to_sentence(on.error()).c_str()), 1;

    for (const auto* joint : {"elbow", "waist_yaw", "left_knee"}) // a SAM, a Nuri, an RMD
        if (auto set = robot->set(joint, {.mode = Mode::position, .position_rad = 0.5, .velocity_rad_s = 0.5}); !set)
            return std::puts(to_sentence(set.error()).c_str()), 1;
    const auto ended = robot->run(std::chrono::milliseconds(10), {}, robot->clock().now() + std::chrono::seconds(2));
    for (const auto* joint : {"elbow", "waist_yaw", "left_knee"})
        std::printf("%s is at %.2f deg\n", joint, units::deg(*robot->state(joint)->position_rad));
    for (const auto& stopped : robot->stop())
        if (stopped.outcome == robot::Stopped::Outcome::failed)
            std::printf("%.*s was not stopped\n", static_cast<int>(stopped.joint.size()), stopped.joint.data());
    return ended ? 0 : 1;
}
