#include "sinew/robot/play.hpp"

#include "sinew/robot/pose.hpp"
#include "tests/robot/blocked_knee.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

/// A joint that is blocked, and what it does to that which blocks it once it is told to hold.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// How it comes to hold.
enum class By {
    play,       ///< which finds that it does not follow
    program,    ///< which has seen enough
    stop,       ///< the policy
    no_command, ///< `command_timeout_s`
};
constexpr std::array<std::pair<By, std::string_view>, 4> ways{
    {{By::play, "a play"}, {By::program, "the program"}, {By::stop, "a stop"}, {By::no_command, "want of commands"}}};

struct Motor {
    std::string_view text;
    double stall_a = 0.0;    ///< what it takes at most
    double gravity_nm = 0.0; ///< of a load that takes 4 tenths of that
};
constexpr std::array<Motor, 3> motors{{
    {"family = \"rmd\"\n[joint.joint]\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n", 7.8, 5.0},
    {"family = \"rmd\"\n[joint.joint]\nmodel = \"MG\"\nprofile = \"lk-2.35\"\n", 7.8, 5.0},
    {"family = \"rmd\"\n[joint.joint]\nmodel = \"MG\"\nprofile = \"myactuator-3\"\n", 7.8, 5.0},
}};

struct Held {
    double pressed_a = 0.0, strongest_a = 0.0; ///< before, and from 0.1 s after it was told to hold
    double fell_deg = 0.0;
    std::string said;
};

/// On its way from 0 to 60 deg at 50 deg/s something is in its way at 30, where a load has the longest lever.
Held hold_against(const Motor& motor, double gravity_nm, By way)
{
    Rig rig(file_of(fmt::format("version = 1\n[bus.b]\n{}bus = \"b\"\nid = 3\nvelocity_max_deg_s = 60\n"
                                "[joint.joint.plant]\nstop_max_deg = 30\ngravity_torque_nm = {}\n"
                                "gravity_zero_deg = -60\n[pose.up]\njoint_deg = 60\n[safety]\npolicy = \"hold\"\n{}",
                                motor.text, gravity_nm, way == By::no_command ? "command_timeout_s = 2.5\n" : "")));
    rig.enable();
    const auto current_a = [&] { return std::abs(rig.simulator->world().look("joint")->current_a); };
    Held out;
    if (way == By::play) {
        PlayOptions options;
        options.each = [&](const SequencePlayer&) { out.pressed_a = std::max(out.pressed_a, current_a()); };
        const auto played = play(*rig.robot, sequence_of(*rig.robot->file().find_pose("up")), options);
        out.said = played ? "" : to_sentence(played.error());
    } else {
        EXPECT_TRUE(rig.robot->set(
            "joint", {.mode = Mode::position, .position_rad = units::rad(60), .velocity_rad_s = units::rad(50)}));
        EXPECT_TRUE(rig.run(2400ms));
        out.pressed_a = current_a();
    }
    if (way == By::program) {
        EXPECT_TRUE(rig.robot->set("joint", {.mode = Mode::hold}));
    }
    if (way == By::stop) {
        EXPECT_EQ(rig.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    }
    const bool is_driven = way == By::play || way == By::program || way == By::no_command;
    const TimePoint told = rig.now();
    double lowest = rig.truth_rad("joint");
    while (rig.now() - told < 3s) {
        if (is_driven) {
            EXPECT_TRUE(rig.run(5ms));
        } else {
            rig.simulator->clock().wait({}, rig.now() + 5ms);
        }
        lowest = std::min(lowest, rig.truth_rad("joint"));
        if (rig.now() - told > (way == By::no_command ? 300ms : 100ms))
            out.strongest_a = std::max(out.strongest_a, current_a());
    }
    out.fell_deg = 30.0 - units::deg(lowest);
    return out;
}

TEST(Pressing, AMotorThatPressesOnWhatBlocksItPressesNoMoreOnceItIsToldToHold)
{
    for (const Motor& motor : motors)
        for (const auto& [way, word] : ways) {
            const Held held = hold_against(motor, 0.0, way);
            EXPECT_GT(held.pressed_a, motor.stall_a) << word << motor.text;
            EXPECT_LT(held.strongest_a, 0.02 * motor.stall_a) << word << motor.text;
        }
}

TEST(Pressing, AnArmThatPressedOnWhatBlockedItIsHeldUpWithNoMoreThanItsLoadTakes)
{
    for (const Motor& motor : motors)
        for (const auto& [way, word] : ways) {
            const Held held = hold_against(motor, motor.gravity_nm, way);
            EXPECT_GT(held.pressed_a, motor.stall_a) << word << motor.text;
            EXPECT_LT(held.strongest_a, 0.5 * motor.stall_a) << word << motor.text;
            EXPECT_LT(held.fell_deg, 0.5) << word << motor.text;
        }
}

constexpr std::uint8_t torque_closed_loop = 0xA1, speed_closed_loop = 0xA2, read_status_1 = 0x9A;

/// A knee that something at 30 deg blocks, and a load that would take it back.
/// The holds behind the first so many times that it was let go.
std::function<bool(const wire::Frame&)> holds_behind(int times, int& let_go)
{
    return [times, &let_go](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return frame.data[0] == speed_closed_loop && let_go > 0 && let_go <= times;
    };
}

double fell_deg(LossyRobot& one)
{
    double lowest = 30.0;
    for (int i = 0; i < 200; ++i) {
        one.simulator->clock().wait({}, one.simulator->clock().now() + 5ms);
        lowest = std::min(lowest, units::deg(one.simulator->world().look("knee")->position_rad));
    }
    return 30.0 - lowest;
}

TEST(Pressing, AStopOfWhichTheHoldBehindTheLettingGoIsLostHoldsAllTheSame)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0;
    one.losses.of_sent = holds_behind(1, let_go);
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_EQ(let_go, 2);
    EXPECT_GT(std::abs(one.simulator->world().look("knee")->current_a), 1.0) << "it is limp";
    EXPECT_LT(fell_deg(one), 1.0);
}

TEST(Pressing, AStopOfWhichEveryHoldBehindTheLettingGoIsLostIsNotSaidToHold)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0;
    one.losses.of_sent = holds_behind(1000, let_go);
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::failed);
    EXPECT_LE(let_go, 3);
}

/// Not said to hold, for it may press on; and not limp.
TEST(Pressing, AStopOfWhichEveryLettingGoWasSpoiledEndsWithAHold)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0, lost = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        const bool is_behind = frame.data[0] == speed_closed_loop && lost < let_go;
        lost += is_behind ? 1 : 0;
        return is_behind;
    };
    std::optional<TimePoint> mute_since;
    one.losses.of_heard = [&](const wire::Frame&) {
        const TimePoint now = one.simulator->clock().now();
        if (let_go == 3 && !mute_since)
            mute_since = now;
        return mute_since && now - *mute_since < 30ms;
    };
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::failed);
    EXPECT_EQ(let_go, 3);
    EXPECT_GT(std::abs(one.simulator->world().look("knee")->current_a), 1.0) << "it is limp";
}

TEST(Pressing, AVelocityOfZeroDoesNotForgetWhatTurnedIntoSomething)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 300ms)), "");
    while (one.knee().state().position_rad.value_or(0.0) < units::rad(29.0))
        ASSERT_TRUE(one.robot->cycle());
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.0}, 20ms)), "");
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 1s)), "");
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

TEST(Pressing, AJointWhoseAnswersAreLostIsLetGoAFewTimesAndNotInEveryCycle)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return false;
    };
    one.losses.of_heard = [](const wire::Frame&) { return true; };
    (void)one.run({.mode = Mode::hold}, 400ms);
    EXPECT_GE(let_go, 1);
    EXPECT_LE(let_go, 3);
}

/// Whoever waits for the answer of a motor that lets go: only what tells it that counts.
TEST(Pressing, AJointOfWhichOtherAnswersAreLostIsLetGoOnce)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return frame.data[0] == read_status_1;
    };
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 2s)), "");
    EXPECT_EQ(let_go, 1);
}

TEST(Pressing, AJointThatHoldsAndNeverHeardToLetGoIsLetGoByAStop)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    one.losses.of_sent = [](const wire::Frame& frame) { return frame.data[0] == torque_closed_loop; };
    ASSERT_EQ(said(one.run({.mode = Mode::hold}, 1s)), "");
    const double pressed_a = std::abs(one.simulator->world().look("knee")->current_a);
    one.losses.of_sent = [](const wire::Frame&) { return false; };
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_GT(pressed_a, 7.0);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 0.5 * pressed_a);
}

TEST(Pressing, AStopThatNobodyHeardToLetGoInIsNotSaidToHoldUntilOneIsHeard)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    one.losses.of_sent = [](const wire::Frame& frame) { return frame.data[0] == torque_closed_loop; };
    for (int stop = 0; stop < 2; ++stop)
        EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::failed) << stop;
    one.losses.of_sent = [](const wire::Frame&) { return false; };
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

TEST(Pressing, WhatAnotherProgramLeftPressingIsLetGoWhenTheRobotIsEnabled)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    one.losses.of_sent = [](const wire::Frame&) { return true; };
    one.robot.reset(); // it was killed
    ASSERT_GT(std::abs(one.simulator->world().look("knee")->current_a), 7.0);
    link::Links links = links_of(*one.simulator);
    auto second = Robot::open(file_of(blocked_knee), links, one.simulator->clock(), {.simulated = true});
    ASSERT_TRUE(second && second->enable());
    ASSERT_EQ(said(second->wait(100ms, 10ms)), "");
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

/// Its velocity of before is no news by then.
TEST(Pressing, AJointThatPressesAndWasSilentBeforeTheStopIsLetGo)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    one.losses.of_heard = [](const wire::Frame&) { return true; };
    ASSERT_EQ(said(one.robot->wait(400ms, 10ms)), "");
    one.losses.of_heard = [](const wire::Frame&) { return false; };
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

TEST(Pressing, AStopThatIsAskedForAgainMeanwhileLetsGoAllTheSame)
{
    for (int at = 1; at <= 50; ++at) {
        LossyRobot one(blocked_knee);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
        int frames = 0;
        one.losses.of_sent = [&](const wire::Frame&) {
            if (++frames == at)
                one.robot->request_stop();
            return false;
        };
        EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed) << at;
        EXPECT_GE(frames, at);
        EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0) << at;
    }
}

/// The relief was on its way when the stop ended it.
TEST(Pressing, AStopThatComesBetweenAHoldAndItsReliefLetsGoAllTheSame)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    const auto ran = one.robot->run(10ms, [&](Robot& robot) {
        EXPECT_TRUE(one.knee().set({.mode = Mode::hold}));
        robot.request_stop();
    });
    EXPECT_FALSE(ran);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

/// Both are one frame, which takes no torque away.
TEST(Pressing, AJointThatPressesAndIsToldAVelocityOfZeroIsLetGoOnceItIsToHold)
{
    for (const bool by_stop : {false, true}) {
        LossyRobot one(blocked_knee);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.0}, 100ms)), "");
        if (by_stop) {
            EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
        } else {
            ASSERT_EQ(said(one.run({.mode = Mode::hold}, 100ms)), "");
        }
        EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0) << by_stop;
    }
}

TEST(Pressing, AStopBehindAnotherOneThatLostAnAnswerLetsGoNoSecondTime)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 2s)), "");
    int let_go = 0, holds = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        let_go += frame.data[0] == torque_closed_loop ? 1 : 0;
        return let_go == 1 && frame.data[0] == speed_closed_loop && ++holds == 3;
    };
    ASSERT_TRUE(one.knee().set({.mode = Mode::hold}));
    ASSERT_TRUE(one.robot->cycle());
    for (int stop = 0; stop < 2; ++stop)
        EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed) << stop;
    EXPECT_GE(holds, 3);
    EXPECT_EQ(let_go, 1);
}

TEST(Pressing, AJointOfASlowLoopIsLetGoOfAsWell)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.knee().set({.mode = Mode::velocity, .velocity_rad_s = 0.5})), "");
    ASSERT_EQ(said(one.robot->wait(4s, 400ms)), "");
    one.simulator->clock().wait({}, one.simulator->clock().now() + 380ms);
    EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::confirmed);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->current_a), 4.0);
}

} // namespace
} // namespace sinew::robot::test
