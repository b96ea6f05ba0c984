#include "sinew/base/units.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/play.hpp"
#include "sinew/sim/links.hpp"
#include <array>
#include <cstdio>

using namespace sinew;

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
    if (auto on = robot->enable(); !on)
        return std::puts(to_sentence(on.error()).c_str()), 1;

    const auto played = robot::play(*robot, *robot->file().find_sequence("wave"));
    if (!played)
        return std::puts(to_sentence(played.error()).c_str()), 1;
    const std::array targets{robot::NamedTarget{"elbow", 1.0}, robot::NamedTarget{"waist_yaw", 0.5}};
    const auto moved = robot::move(*robot, targets, std::chrono::seconds(2)); // both arrive after two seconds
    if (!moved)
        return std::puts(to_sentence(moved.error()).c_str()), 1;
    for (const auto& target : targets)
        std::printf("%s is at %.2f deg\n", target.joint.c_str(), units::deg(*robot->state(target.joint)->position_rad));
    return robot->stop().empty() ? 1 : 0;
}
