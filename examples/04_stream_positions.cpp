#include "sinew/base/units.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cmath>
#include <cstdio>

using namespace sinew;
using namespace std::chrono_literals;

// A sine, a hundred positions a second. The first one starts where the joint is, for a jump would be refused.
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

    robot::Joint& elbow = *robot->find("elbow");
    const auto begin = robot->clock().now();
    const double start = *elbow.state().position_rad;
    double furthest = 0.0;
    int refused = 0;
    const auto each = [&](robot::Robot& all) {
        const double t = seconds(all.clock().now() - begin);
        const double target = start + 0.4 * (1.0 - std::cos(2.0 * t));
        if (const auto set = elbow.set({.mode = robot::Mode::position, .position_rad = target}); !set)
            std::printf("%s\n", to_sentence(set.error()).c_str()), ++refused;
        furthest = std::max(furthest, *elbow.state().position_rad - start);
    };
    const auto ended = robot->run(10ms, each, begin + 4s);
    std::printf("went %.1f deg far, %d targets refused\n", units::deg(furthest), refused);
    robot->stop();
    return ended && refused == 0 && furthest > 0.7 ? 0 : 1;
}
