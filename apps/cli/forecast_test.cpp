#include "apps/cli/forecast.hpp"

#include "sinew/base/units.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

/// The demo robot with one of its buses only.
config::RobotFile only(std::string_view bus)
{
    auto file = *config::read_robot_file("robots/demo.toml");
    std::erase_if(file.buses, [&](const auto& one) { return one.name != bus; });
    std::erase_if(file.joints, [&](const auto& one) { return one.bus.value != bus; });
    file.poses.clear();
    file.sequences.clear();
    return file;
}

/// How long a cycle of a robot takes whose joints are all sent to another place in each. Now and then there is more in
/// a cycle, and less in none, so it is the one in the middle.
double cycle_s(const config::RobotFile& file)
{
    sim::Worlds worlds;
    link::Links links;
    sim::add(links, worlds);
    link::RealClock real;
    const std::string uri = fmt::format("sim:{}#{}", file.path, file.buses.front().name);
    link::Clock* const clock = *sim::clock_for(uri, real, worlds);
    auto robot = robot::Robot::open(file, links, *clock, {.simulated = true});
    if (!robot || !robot->enable())
        return 0.0;
    std::vector<double> took;
    for (int i = 0; i < 201; ++i) {
        const TimePoint begun = clock->now();
        for (auto& joint : robot->joints()) {
            const double to = units::rad(0.01 * i);
            static_cast<void>(joint.set({.mode = robot::Mode::position, .position_rad = joint.nearest_step_rad(to)}));
        }
        if (!robot->cycle())
            return 0.0;
        took.push_back(seconds(clock->now() - begun));
    }
    std::ranges::sort(took);
    return took[took.size() / 2];
}

TEST(Forecast, ACycleOfARobotTakesWhatThePlanSaysWithinTwoPercent)
{
    const auto buses = buses_of("robots/demo.toml");
    ASSERT_TRUE(buses);
    ASSERT_EQ(buses->size(), 3U);
    for (const auto& bus : *buses) {
        const auto plan = forecast(*bus.family, bus.devices, bus.bit_rate);
        const double rate = 1.0 / cycle_s(only(bus.name));
        const double least = cycles_per_s(plan.line, plan.cycle, bus::Stuffing::most);
        const double most = cycles_per_s(plan.line, plan.cycle, bus::Stuffing::least);
        fmt::print("{}: planned {:.1f} to {:.1f}, measured {:.1f} cycles a second\n", bus.name, least, most, rate);
        EXPECT_GE(rate, least * 0.98) << bus.name;
        EXPECT_LE(rate, most * 1.02) << bus.name;
    }
}

} // namespace
} // namespace sinew::cli
