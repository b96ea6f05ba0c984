#pragma once
#include "sinew/base/units.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/simulator.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <string_view>

/// A robot over the simulator of its own file, in virtual time.
namespace sinew::robot::test {

/// Links that know the buses of one simulator as `sim:FILE#BUS`.
inline link::Links links_of(sim::Simulator& simulator)
{
    link::Links links;
    links.add({.name = "sim",
               .form = "sim:FILE#BUS",
               .says = "A bus of this test.",
               .options = {},
               .open = [&simulator](const link::Uri& uri, link::Clock&) { return simulator.open(uri.fragment); }});
    return links;
}

inline config::RobotFile file_of(std::string_view text)
{
    auto file = config::parse_robot_file(text, "robot.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

inline config::RobotFile demo()
{
    auto file = config::read_robot_file("robots/demo.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

struct Rig {
    /// `host` where the host believes something else than the simulator does.
    explicit Rig(const config::RobotFile& file, bus::Settings settings = {}) : Rig(file, file, settings) {}
    Rig(const config::RobotFile& file, const config::RobotFile& host, bus::Settings settings = {})
        : simulator(*sim::Simulator::make(file))
    {
        auto opened =
            Robot::open(host, links_of(*simulator), simulator->clock(), {.simulated = true, .settings = settings});
        EXPECT_TRUE(opened.has_value()) << (opened ? "" : to_sentence(opened.error()));
        robot = std::make_unique<Robot>(std::move(*opened));
    }
    void enable()
    {
        const auto on = robot->enable();
        ASSERT_TRUE(on.has_value()) << to_sentence(on.error());
    }
    TimePoint now() { return simulator->clock().now(); }
    /// Where the simulated shaft of a joint is, in joint units.
    double truth_rad(const Joint& joint) const
    {
        return Mounting::of(joint.file()).to_joint(simulator->world().look(joint.name())->position_rad);
    }
    double truth_rad(std::string_view joint) { return truth_rad(*robot->find(joint)); }
    double truth_rad_s(std::string_view joint)
    {
        const auto mounting = Mounting::of(robot->find(joint)->file());
        return simulator->world().look(joint)->velocity_rad_s / (mounting.direction * mounting.ratio);
    }
    std::expected<void, Error> run(Duration duration, Duration period = std::chrono::milliseconds{10})
    {
        return robot->wait(duration, period);
    }
    void inject(sim::FaultKind kind, std::string_view joint, double for_s = 0.0)
    {
        sim::Fault fault{.kind = kind, .joint = std::string(joint), .for_s = for_s};
        simulator->world().inject(fault);
    }

    std::unique_ptr<sim::Simulator> simulator;
    std::unique_ptr<Robot> robot;
};

inline std::string said(const std::expected<void, Error>& result)
{
    return result ? std::string() : to_sentence(result.error());
}

} // namespace sinew::robot::test
