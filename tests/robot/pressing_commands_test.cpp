#include "sinew/robot/pressing.hpp"
#include "tests/robot/blocked_knee.hpp"

#include <gtest/gtest.h>

/// Joints that press on something, and what they are told before they are to hold.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t torque_closed_loop = 0xA1;
constexpr double carries_a = 4.0; ///< more than its load takes, and less than it presses with

double current_a(sim::Simulator& simulator)
{
    return std::abs(simulator.world().look("knee")->current_a);
}

/// It turns, at a speed that its load or what it squeezes leaves it.
TEST(Pressing, WhoeverTurnsAtLessThanHalfOfWhatHeWasToldMaySqueezeSomethingSoft)
{
    const auto robot = resolve(file_of(blocked_knee));
    ASSERT_TRUE(robot);
    const auto& device = robot->joints.front().device;
    const TimePoint now{1s};
    const auto at = [&](double velocity_rad_s) {
        actuator::State state;
        state.position_rad = {0.1, now};
        state.velocity_rad_s = {velocity_rad_s, now};
        state.current_a = {7.5, now};
        return state;
    };
    const Command told{.mode = Mode::velocity, .velocity_rad_s = -0.5};
    EXPECT_TRUE(presses(device, told, at(-0.03), now));
    EXPECT_FALSE(presses(device, told, at(-0.45), now));
    const Command sent{.mode = Mode::position, .position_rad = 1.0, .velocity_rad_s = 0.5};
    EXPECT_TRUE(presses(device, sent, at(0.03), now));
    EXPECT_FALSE(presses(device, sent, at(0.45), now));
}

TEST(Pressing, AJointThatIsSentToWhereItIsBlockedIsLetGoByWhatHoldsItNext)
{
    for (const bool by_stop : {false, true}) {
        LossyRobot one(blocked_knee);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
        const double here_rad = *one.knee().state().position_rad;
        ASSERT_EQ(said(one.run({.mode = Mode::position, .position_rad = here_rad}, 200ms)), "");
        if (by_stop) {
            EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
        } else {
            ASSERT_EQ(said(one.run({.mode = Mode::hold}, 500ms)), "");
        }
        EXPECT_LT(current_a(*one.simulator), carries_a) << by_stop;
    }
}

/// And no robot lets go of a load that turned freely meanwhile.
TEST(Pressing, AJointThatTurnedAwayFromWhatBlockedItIsNotLetGo)
{
    LossyRobot one(std::string(blocked_knee).replace(blocked_knee.find("nm = 5"), 6, "nm = 0"));
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = -0.5}, 1s)), "");
    int let_go = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return false;
    };
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 1s)), "");
    EXPECT_EQ(let_go, 0);
}

/// One frame drives all of them.
TEST(Pressing, AMotorOfAGroupThatTurnedAwayFromWhatBlockedItIsNotLetGo)
{
    auto text = std::string(blocked_knee).replace(blocked_knee.find("nm = 5"), 6, "nm = 0");
    LossyRobot one(text + "[joint.other]\nbus = \"r\"\nid = 2\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n");
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0, groups = 0;
    bool loses = true;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        const bool is_group = frame.can_id == 0x280;
        const bool lets_go = frame.can_id == 0x141 && frame.data[0] == torque_closed_loop;
        let_go += lets_go ? 1 : 0;
        groups += is_group ? 1 : 0;
        return lets_go && loses;
    };
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 500ms)), "");
    ASSERT_GT(let_go, 0) << "nor was it acknowledged";
    loses = false;
    ASSERT_EQ(said(one.robot->set("other", {.mode = Mode::current, .current_a = 0.1})), "");
    ASSERT_EQ(said(one.run({.mode = Mode::current, .current_a = -0.4}, 60ms)), "");
    ASSERT_GT(groups, 0);
    let_go = 0;
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_EQ(let_go, 0);
}

/// What ends a cycle before its exchange was planned, and told nobody.
TEST(Pressing, AHoldThatWasPlannedAndNeverSentIsNoHold)
{
    const std::string two = blocked_knee +
                            "[bus.s]\nfamily = \"rmd\"\n[joint.other]\nbus = \"s\"\nid = 1\nmodel = \"MG\"\n"
                            "profile = \"rmd-2.35\"\n";
    for (int cycles = 0; cycles < 10; ++cycles) {
        Rig rig(file_of(two));
        rig.enable();
        ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = 0.5})), "");
        ASSERT_EQ(said(rig.run(2s)), "");
        rig.inject(sim::FaultKind::unplug, "other");
        for (int i = 0; rig.robot->enabled(); ++i) {
            rig.simulator->clock().wait({}, rig.now() + 90ms);
            if (i == cycles)
                (void)rig.robot->set("knee", {.mode = Mode::hold});
            (void)rig.robot->cycle();
        }
        EXPECT_LT(current_a(*rig.simulator), carries_a) << cycles;
    }
}

/// A leg that was let go while it turned, and carries its load again.
TEST(Pressing, WhatAJointTookBeforeItWasReleasedSaysNothingOfWhatItHoldsLater)
{
    LossyRobot one("version = 1\n[safety]\npolicy = \"release\"\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\n"
                   "id = 1\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\nvelocity_max_deg_s = 500\n[joint.knee.plant]\n"
                   "gravity_torque_nm = 5\ngravity_zero_deg = 90\n");
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 100ms)), "");
    (void)one.robot->stop();
    ASSERT_EQ(said(one.robot->enable()), "");
    int let_go = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return false;
    };
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 2s)), "");
    EXPECT_EQ(let_go, 0);
}

/// Its program has something else to do before its first cycle.
TEST(Pressing, WhatAnotherProgramPressedOnIsLetGoOfByTheFirstEnable)
{
    const auto file = file_of(blocked_knee);
    Rig rig(file);
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = 0.5})), "");
    ASSERT_EQ(said(rig.run(2s)), "");
    rig.robot.reset();
    ASSERT_GT(current_a(*rig.simulator), carries_a);
    auto second = Robot::open(file, links_of(*rig.simulator), rig.simulator->clock(), {.simulated = true});
    ASSERT_TRUE(second);
    ASSERT_EQ(said(second->enable()), "");
    rig.simulator->clock().wait({}, rig.now() + 500ms);
    EXPECT_LT(current_a(*rig.simulator), carries_a);
}

TEST(Pressing, WhatAnEnableFailedToLetGoOfIsLetGoOfByTheStopThatFollows)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    one.losses.of_sent = [](const wire::Frame& frame) { return frame.data[0] == torque_closed_loop; };
    (void)one.robot->stop();
    ASSERT_GT(current_a(*one.simulator), carries_a);
    bool lost = false;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        return frame.data[0] == torque_closed_loop && !std::exchange(lost, true);
    };
    EXPECT_NE(said(one.robot->enable()), "");
    EXPECT_LT(current_a(*one.simulator), carries_a);
}

/// Its adapter was out when it was stopped, so it turned on until something was in its way.
TEST(Pressing, AJointThatRanIntoSomethingWhileItCouldNotBeStoppedIsLetGoOnceItIsEnabled)
{
    Rig rig(file_of(blocked_knee));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = 0.4})), "");
    ASSERT_EQ(said(rig.run(300ms)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("r", false));
    EXPECT_NE(said(rig.run(1s)), "");
    rig.simulator->clock().wait({}, rig.now() + 3s);
    ASSERT_GT(current_a(*rig.simulator), carries_a);
    ASSERT_TRUE(rig.simulator->set_plugged("r", true));
    rig.enable();
    ASSERT_EQ(said(rig.run(500ms)), "");
    EXPECT_LT(current_a(*rig.simulator), carries_a);
}

} // namespace
} // namespace sinew::robot::test
