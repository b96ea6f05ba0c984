#include "tests/robot/rig.hpp"

#include <gtest/gtest.h>

/// What a device does that hears nothing more: the table of docs/guide/safety.md, line by line.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// One joint of each family, each on a bus of its own.
constexpr std::string_view three = R"(
version = 1
[bus.s]
family = "sam"
[bus.n]
family = "nuri"
bit_rate = 115200
[bus.r]
family = "rmd"
[joint.sam]
bus = "s"
id = 1
model = "SAM-20"
velocity_max_deg_s = 100
[joint.nuri]
bus = "n"
id = 1
velocity_max_deg_s = 100
[joint.rmd]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
velocity_max_deg_s = 100
)";

/// The links of all three are cut while the devices keep their supply; then the world goes on for `after`.
void cut(Rig& rig, Duration after)
{
    for (const auto* bus : {"s", "n", "r"})
        ASSERT_TRUE(rig.simulator->set_plugged(bus, false));
    rig.simulator->clock().wait({}, rig.now() + after);
}

void command_all(Rig& rig, const Command& command)
{
    for (Joint& joint : rig.robot->joints())
        ASSERT_EQ(said(joint.set(command)), "");
}

/// How far away a joint is when somebody has pushed it and let go.
double pushed_by_deg(Rig& rig, const char* joint, double torque_nm)
{
    const double before = rig.truth_rad(joint);
    sim::Fault push{.kind = sim::FaultKind::push, .joint = joint, .for_s = 1.0};
    push.torque_nm = torque_nm;
    rig.simulator->world().inject(push);
    rig.simulator->clock().wait({}, rig.now() + 1500ms);
    return units::deg(std::abs(rig.truth_rad(joint) - before));
}

TEST(Unreachable, ADeviceGoesToItsLastTargetAndHoldsIt)
{
    Rig rig(file_of(three));
    rig.enable();
    command_all(rig, {.mode = Mode::position, .position_rad = units::rad(60), .velocity_rad_s = units::rad(60)});
    ASSERT_EQ(said(rig.run(500ms)), "");
    cut(rig, 5s);
    // The robot walks a SAM there a step a cycle, the others were told the whole move.
    EXPECT_NEAR(units::deg(rig.truth_rad("sam")), 30.0, 2.0);
    EXPECT_NEAR(units::deg(rig.truth_rad("nuri")), 60.0, 0.5);
    EXPECT_NEAR(units::deg(rig.truth_rad("rmd")), 60.0, 0.5);
    for (const auto* joint : {"sam", "nuri", "rmd"})
        EXPECT_NEAR(pushed_by_deg(rig, joint, 0.2), 0.0, 0.5) << joint << " holds";
}

TEST(Unreachable, ADeviceThatTurnsTurnsOnWithoutEnd)
{
    Rig rig(file_of(three));
    rig.enable();
    command_all(rig, {.mode = Mode::velocity, .velocity_rad_s = units::rad(40)});
    ASSERT_EQ(said(rig.run(1s)), "");
    cut(rig, 10s);
    for (const auto* joint : {"sam", "nuri", "rmd"})
        EXPECT_GT(units::deg(rig.truth_rad_s(joint)), 10.0) << joint;
}

TEST(Unreachable, ADeviceThatIsPushedByACurrentIsPushedOn)
{
    Rig rig(file_of(three));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("rmd", {.mode = Mode::current, .current_a = 1.0})), "");
    ASSERT_EQ(said(rig.run(100ms)), "");
    const double before = rig.truth_rad_s("rmd");
    cut(rig, 1s);
    EXPECT_GT(rig.truth_rad_s("rmd"), before + 0.1);
}

TEST(Unreachable, ADeviceThatWasReleasedStaysFree)
{
    Rig rig(file_of(three));
    rig.enable();
    command_all(rig, {.mode = Mode::release});
    ASSERT_EQ(said(rig.run(500ms)), "");
    cut(rig, 1s);
    for (const auto* joint : {"sam", "nuri", "rmd"}) {
        EXPECT_EQ(rig.simulator->world().look(joint)->current_a, 0.0) << joint;
        EXPECT_GT(pushed_by_deg(rig, joint, 2.0), 5.0) << joint << " comes back to where it was";
    }
}

/// The supply is gone with the cable, and what a device was told with it.
TEST(Unreachable, ADeviceThatWasWithoutItsSupplyIsFreeWhenItIsBackAndDoesNotGoOn)
{
    Rig rig(file_of(three));
    rig.enable();
    command_all(rig, {.mode = Mode::velocity, .velocity_rad_s = units::rad(40)});
    ASSERT_EQ(said(rig.run(1s)), "");
    for (const auto* bus : {"s", "n", "r"})
        ASSERT_TRUE(rig.simulator->set_plugged(bus, false));
    for (const auto* joint : {"sam", "nuri", "rmd"})
        rig.simulator->world().find_device(joint)->power_cycle();
    rig.simulator->clock().wait({}, rig.now() + 10s);
    for (const auto* joint : {"sam", "nuri", "rmd"})
        EXPECT_NEAR(rig.truth_rad_s(joint), 0.0, 1e-3) << joint;
}

} // namespace
} // namespace sinew::robot::test
