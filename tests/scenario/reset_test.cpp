#include "sinew/base/units.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/sim/firmware/sam_device.hpp"
#include "tests/scenario/robot.hpp"

#include <array>
#include <fmt/format.h>
#include <gtest/gtest.h>

/// A device that has started afresh is noticed, and what it forgot is set again.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using actuator::Depth;
using actuator::Mode;

void power_cycle(Robot& robot, const std::string& joint)
{
    robot.simulator().world().find_device(joint)->power_cycle();
    robot.wait(100ms);
}

TEST(Reset, ASamHasItsGainsAgain)
{
    Robot robot(robot_file(R"(
version = 1
[bus.s]
family = "sam"
[joint.servo]
bus = "s"
id = 1
model = "SAM-20"
[joint.servo.runtime]
p_gain = 77
d_gain = 5
i_gain = 2
)"));
    const auto& servo = robot.resolved().joints[0];
    const auto gains = [&] {
        const auto pd = robot.line("s").call(1, sam::ReadPdGain{});
        const auto i = robot.line("s").call(1, sam::ReadIGain{});
        EXPECT_TRUE(pd && i);
        return std::array<int, 3>{pd->p_gain, pd->d_gain, i->i_gain};
    };
    const std::array<int, 3> own{77, 5, 2};
    robot.set_up(servo);
    EXPECT_EQ(gains(), own);
    EXPECT_EQ(robot.reset_of(servo), "");
    power_cycle(robot, "servo");
    EXPECT_NE(gains(), own);
    EXPECT_NE(robot.reset_of(servo), "");
    robot.set_up(servo);
    EXPECT_EQ(gains(), own);
    EXPECT_EQ(robot.reset_of(servo), "");
    EXPECT_EQ(robot.simulator().world().find_device("servo")->flash_writes(), 0U);
}

TEST(Reset, AnRmdHasItsAccelerationAndItsGainsAgain)
{
    for (const std::string_view line : {"rmd-2.35", "gyems-1.62"}) {
        const bool together = line == "gyems-1.62";
        Robot robot(robot_file(fmt::format(
            "version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.motor]\nbus = \"r\"\n"
            "id = 1\nmodel = \"MG\"\nprofile = \"{}\"\n[joint.motor.runtime]\n"
            "acceleration_deg_s2 = 321\nangle_kp = 91\nangle_ki = 45\n{}\n",
            line, together ? "speed_kp = 1\nspeed_ki = 2\ncurrent_kp = 3\ncurrent_ki = 4" : "angle_kd = 6")));
        const auto& motor = robot.resolved().joints[0];
        const auto acceleration = [&] { return robot.line("r").call(1, rmd::ReadAcceleration{})->acceleration; };
        robot.set_up(motor);
        EXPECT_EQ(acceleration(), 321) << line;
        EXPECT_EQ(robot.reset_of(motor), "") << line;
        power_cycle(robot, "motor");
        EXPECT_NE(acceleration(), 321) << line;
        EXPECT_NE(robot.reset_of(motor), "") << line;
        robot.set_up(motor);
        EXPECT_EQ(acceleration(), 321) << line;
        EXPECT_EQ(robot.reset_of(motor), "") << line;
        EXPECT_EQ(robot.simulator().world().find_device("motor")->flash_writes(), 0U) << line;
    }
}

TEST(Reset, AnRmdThatHasLostItsTurnsIsNoticedWithoutAnySetting)
{
    Robot robot(robot_file("version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.motor]\nbus = \"r\"\nid = 1\n"
                           "model = \"MG\"\nprofile = \"rmd-2.35\"\n"));
    const auto& motor = robot.resolved().joints[0];
    robot.command(motor, {.mode = Mode::position, .position_rad = units::rad(800), .velocity_rad_s = units::rad(600)},
                  robot.read(motor, Depth::full));
    robot.wait(3s);
    EXPECT_EQ(robot.reset_of(motor), "") << "it was sent there";
    EXPECT_EQ(robot.reset_of(motor), "");
    power_cycle(robot, "motor");
    EXPECT_NE(robot.reset_of(motor), "");
}

TEST(Reset, AnLkMotorThatSwitchedItselfOnIsNoticed)
{
    Robot robot(robot_file("version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.motor]\nbus = \"r\"\nid = 1\n"
                           "model = \"MG\"\nprofile = \"lk-2.35\"\n"));
    const auto& motor = robot.resolved().joints[0];
    robot.command(motor, {.mode = Mode::release});
    EXPECT_EQ(robot.reset_of(motor), "");
    EXPECT_EQ(robot.read(motor, Depth::full).enabled, false);
    power_cycle(robot, "motor");
    EXPECT_NE(robot.reset_of(motor), "");
    EXPECT_EQ(robot.read(motor, Depth::full).enabled, true);
}

TEST(Reset, ANuriThatForgotItsSettingsIsNoticed) // N14: a device whose settings do not persist
{
    Robot robot(robot_file(R"(
version = 1
[bus.n]
family = "nuri"
bit_rate = 115200
[joint.turner]
bus = "n"
id = 1
[joint.turner.sim]
settings_persist = false
)"));
    const auto& turner = robot.resolved().joints[0];
    ASSERT_TRUE(robot.line("n").send(1, nuri::SetExternalGearRatio{.gear_ratio = 40}).has_value());
    EXPECT_EQ(robot.reset_of(turner), "");
    EXPECT_EQ(robot.reset_of(turner), "");
    power_cycle(robot, "turner");
    EXPECT_NE(robot.reset_of(turner), "");
}

} // namespace
} // namespace sinew::test
