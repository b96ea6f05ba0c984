#include "sinew/base/units.hpp"
#include "tests/scenario/robot.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using actuator::Depth;
using actuator::Mode;

/// What the driver reads against what the shaft does; one unit of the protocol apart at most.
void expect_agreement(Robot& robot, const ResolvedJoint& joint)
{
    const auto state = robot.read(joint, Depth::full);
    const double step = robot.driver(joint.joint->name).capabilities().position_step_rad;
    EXPECT_NEAR(*state.position_rad, robot.look(joint.joint->name).position_rad, step) << joint.joint->name;
}

TEST(Scenario, EveryJointOfTheDemoGoesWhereItIsSent)
{
    Robot robot(demo());
    ASSERT_EQ(robot.resolved().joints.size(), 16U);
    for (const auto& joint : robot.resolved().joints) {
        const auto& can = robot.driver(joint.joint->name).capabilities();
        const auto before = robot.read(joint, Depth::full);
        const double target = *before.position_rad + units::rad(20);
        actuator::Command go{.mode = Mode::position, .position_rad = target};
        if (can.velocity_limit)
            go.velocity_rad_s = units::rad(60);
        robot.command(joint, go, before);
        robot.wait(1s);
        EXPECT_NEAR(robot.look(joint.joint->name).position_rad, target, can.position_step_rad) << joint.joint->name;
        expect_agreement(robot, joint);
    }
    for (const auto* bus : {"left", "waist", "legs"})
        EXPECT_EQ(robot.weather(bus).timeouts + robot.weather(bus).strays, 0U) << bus;
}

TEST(Scenario, AMoveWithASpeedTakesTheTimeThatTheSpeedAsksFor)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints) {
        if (!robot.driver(joint.joint->name).capabilities().velocity_limit)
            continue;
        const auto before = robot.read(joint, Depth::full);
        robot.command(joint,
                      {.mode = Mode::position,
                       .position_rad = *before.position_rad + units::rad(90),
                       .velocity_rad_s = units::rad(30)},
                      before);
        robot.wait(1500ms);
        // Half of the way in half of the time; the ramp at the start costs less than a degree.
        const double way = units::deg(robot.look(joint.joint->name).position_rad - *before.position_rad);
        EXPECT_GT(way, 44.0) << joint.joint->name;
        EXPECT_LE(way, 45.1) << joint.joint->name << ": never faster than asked";
    }
}

TEST(Scenario, EveryJointTurnsInTheSenseOfItsVelocityAndHolds)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints)
        for (const double sense : {1.0, -1.0}) {
            robot.command(joint, {.mode = Mode::velocity, .velocity_rad_s = sense * units::rad(60)},
                          robot.read(joint, Depth::full));
            robot.wait(1500ms);
            const auto state = robot.read(joint, Depth::full);
            EXPECT_GT(sense * robot.look(joint.joint->name).velocity_rad_s, 0.0) << joint.joint->name;
            ASSERT_TRUE(state.velocity_rad_s.has_value()) << joint.joint->name;
            EXPECT_GT(sense * *state.velocity_rad_s, 0.0) << joint.joint->name;
            robot.command(joint, {.mode = Mode::hold}, state);
            robot.wait(2s);
            EXPECT_NEAR(robot.look(joint.joint->name).velocity_rad_s, 0.0, 1e-9) << joint.joint->name;
        }
}

TEST(Scenario, ReleasedJointsHaveNoDriveAndComeBack)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints) {
        robot.command(joint, {.mode = Mode::release}, robot.read(joint, Depth::full));
        const auto mode = std::string(robot.look(joint.joint->name).mode);
        EXPECT_TRUE(mode == "passive" || mode == "off") << joint.joint->name << " is " << mode;
        const auto before = robot.read(joint, Depth::full);
        robot.command(joint, {.mode = Mode::position, .position_rad = *before.position_rad + 0.2}, before);
        robot.wait(2s);
        EXPECT_NEAR(robot.look(joint.joint->name).position_rad, *before.position_rad + 0.2, 0.02) << joint.joint->name;
    }
}

TEST(Scenario, AProfileThatNobodyNamedCanOnlyBeSlow) // R01: the device reads 0.01 deg/s a unit, the host sends 1
{
    Robot robot(robot_file(R"(
version = 1
[bus.legs]
family = "rmd"
[joint.knee]
bus = "legs"
id = 1
model = "MG"
)"));
    const auto& knee = robot.resolved().joints[0];
    robot.command(knee, {.mode = Mode::position, .position_rad = units::rad(90), .velocity_rad_s = units::rad(50)},
                  robot.read(knee, Depth::full));
    robot.wait(2s);
    EXPECT_NEAR(units::deg(robot.look("knee").position_rad), 1.0, 0.1)
        << "a hundredth of the speed, and never a hundredfold";
}

} // namespace
} // namespace sinew::test
