#include "sinew/robot/sequence.hpp"

#include "sinew/base/units.hpp"
#include "sinew/robot/pose.hpp"
#include "tests/support/allocations.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;
using Status = SequencePlayer::Status;

constexpr std::string_view arm = R"(version = 1
[bus.left]
family = "sam"
[joint.elbow]
bus = "left"
id = 3
velocity_max_deg_s = 100
acceleration_max_deg_s2 = 400
[joint.wrist]
bus = "left"
id = 4
velocity_max_deg_s = 50
[pose.ready]
elbow_deg = 90
wrist_deg = 20
[pose.rest]
elbow_deg = 0
wrist_deg = 0
)";

config::RobotFile file_with(std::string_view steps)
{
    auto file = config::parse_robot_file(
        std::string{arm} + "[sequence.test]\nsteps = [\n" + std::string{steps} +
            "]\n[sequence.nod]\nsteps = [{move = {wrist_deg = 5}}, {move = {wrist_deg = 0}}]\n",
        "r.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return file.value_or(config::RobotFile{});
}

/// A loop in virtual time with joints that are wherever they are told to be.
struct Stage {
    explicit Stage(std::string_view steps, std::string_view sequence = "test")
        : file(file_with(steps)), player(file, *file.find_sequence(sequence))
    {
        for (std::size_t i = 0; i < file.joints.size(); ++i) {
            states.push_back({.at = now, .position_rad = {0.0, now}, .velocity_rad_s = {0.0, now}});
            shown.push_back(0.0);
        }
    }

    /// Until the end or for so long.
    Status run(Duration longest = 1h, Duration period = 10ms)
    {
        const TimePoint end = now + longest;
        Status status = Status::running;
        while (status == Status::running && now < end) {
            status = player.next(now, states);
            follow();
            now += period;
        }
        return status;
    }

    void follow()
    {
        for (std::size_t i = 0; i < states.size(); ++i) {
            const auto& target = player.targets()[i];
            if (!target)
                continue;
            longest_leap_deg = std::max(longest_leap_deg, std::abs(units::deg(target->position_rad) - shown[i]));
            shown[i] = units::deg(target->position_rad);
            states[i].position_rad = {target->position_rad, now};
            states[i].velocity_rad_s = {target->velocity_rad_s, now};
        }
    }

    double elapsed_s() const { return seconds(now.time_since_epoch()); }

    config::RobotFile file;
    TimePoint now{};
    std::vector<actuator::State> states;
    std::vector<double> shown; ///< degrees
    double longest_leap_deg = 0.0;
    SequencePlayer player;
};

TEST(SequencePlayer, AllJointsOfAPoseArriveTogether)
{
    Stage stage(R"({pose = "ready"})");
    EXPECT_EQ(stage.run(500ms), Status::running);
    EXPECT_GT(stage.shown[0], 10.0);
    EXPECT_LT(stage.shown[0], 80.0);
    EXPECT_GT(stage.shown[1], 2.0);
    EXPECT_LT(stage.shown[1], 18.0);
    EXPECT_EQ(stage.player.moving().size(), 2U);
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_DOUBLE_EQ(stage.shown[0], 90.0);
    EXPECT_DOUBLE_EQ(stage.shown[1], 20.0);
    EXPECT_TRUE(stage.player.moving().empty());
    // d/v + v/a + a/j, whatever the period of the loop is.
    EXPECT_NEAR(stage.elapsed_s(), 0.9 + 0.25 + 0.1, 0.021);
    EXPECT_EQ(stage.player.next(stage.now + 1s, stage.states), Status::done);
}

TEST(SequencePlayer, AJointThatWasNotMovedYetHasNoTarget)
{
    Stage stage(R"({move = {elbow_deg = 10}}, {wait_s = 1}, {move = {wrist_deg = 3}})");
    stage.run(1s);
    EXPECT_TRUE(stage.player.targets()[0]);
    EXPECT_FALSE(stage.player.targets()[1]);
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_TRUE(stage.player.targets()[1]);
}

TEST(SequencePlayer, TheFirstTargetIsWhereTheJointWasMeasured)
{
    Stage stage(R"({pose = "ready"})");
    stage.states[0].position_rad = {units::rad(33.0), stage.now};
    stage.player.next(stage.now, stage.states);
    EXPECT_DOUBLE_EQ(units::deg(stage.player.targets()[0]->position_rad), 33.0);
    EXPECT_DOUBLE_EQ(units::deg(stage.player.targets()[1]->position_rad), 0.0);
}

TEST(SequencePlayer, AJointThatWasNeverMeasuredIsNotMoved)
{
    Stage stage(R"({pose = "ready"})");
    stage.states[1].position_rad.reset();
    EXPECT_EQ(stage.run(), Status::failed);
    EXPECT_EQ(to_sentence(stage.player.error()), "r.toml:21:1: wrist did not tell its position yet");
    EXPECT_FALSE(stage.player.targets()[0]);
}

TEST(SequencePlayer, HalfTheSpeedTakesTwiceAsLong)
{
    Stage stage(R"({pose = "ready", speed = 0.5})");
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_NEAR(stage.elapsed_s(), 2 * (0.9 + 0.25 + 0.1), 0.021);
}

TEST(SequencePlayer, ADurationIsKeptAndOneThatIsTooShortFailsBeforeAnythingMoves)
{
    Stage stage(R"({pose = "ready", duration_s = 4}, {pose = "rest", duration_s = 0.5})");
    EXPECT_EQ(stage.run(), Status::failed);
    EXPECT_NEAR(stage.elapsed_s(), 4.0, 0.021);
    EXPECT_DOUBLE_EQ(stage.shown[0], 90.0);
    EXPECT_EQ(stage.player.error().code, Errc::out_of_range);
    EXPECT_EQ(to_sentence(stage.player.error()),
              "r.toml:21:35: elbow: this motion cannot take 0.5 s; it can take 1.25 s");
}

TEST(SequencePlayer, WaitsAndRepetitionsDoNotDriftWithTheLoop)
{
    Stage stage(R"({repeat = 100, steps = [{wait_s = 0.1}, {wait_s = 0.015}]})");
    EXPECT_EQ(stage.run(1h, 7ms), Status::done);
    EXPECT_NEAR(stage.elapsed_s(), 11.5, 0.0141);
    EXPECT_EQ(stage.player.steps_begun(), 200U);
}

TEST(SequencePlayer, ACallPlaysTheOtherSequenceAndComesBack)
{
    Stage stage(R"({call = "nod", repeat = 3}, {move = {elbow_deg = 7}})");
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_EQ(stage.player.steps_begun(), 7U);
    EXPECT_DOUBLE_EQ(stage.shown[0], 7.0);
    EXPECT_DOUBLE_EQ(stage.shown[1], 0.0);
}

TEST(SequencePlayer, ForEverGoesOnUntilItIsStopped)
{
    Stage stage(R"({repeat = "forever", steps = [{pose = "ready"}, {pose = "rest"}]})");
    EXPECT_EQ(stage.run(100s), Status::running);
    EXPECT_GT(stage.player.motions(), 50U);
    stage.player.stop();
    EXPECT_EQ(stage.run(1s), Status::stopped);
    const double there = stage.shown[0];
    EXPECT_EQ(stage.run(1s), Status::stopped);
    EXPECT_EQ(stage.shown[0], there);
}

TEST(SequencePlayer, RepeatedStepsThatTakeNoTimeLeaveTheLoopItsTime)
{
    // The joint stands there already: a pass takes no time, and for ever would be one call.
    Stage stage(R"({repeat = "forever", steps = [{move = {elbow_deg = 0}}]})");
    EXPECT_EQ(stage.run(50ms), Status::running);
    EXPECT_LE(stage.player.steps_begun(), 64U * 5U);
}

TEST(SequencePlayer, AStopSlowsDownWithinTheLimits)
{
    Stage stage(R"({pose = "ready"})");
    stage.run(600ms);
    const double where = stage.shown[0];
    EXPECT_NEAR(units::deg(stage.player.targets()[0]->velocity_rad_s), 100.0, 1e-6);
    stage.player.stop();
    stage.player.next(stage.now, stage.states);
    EXPECT_TRUE(stage.player.slowing_down());
    double before = 100.0;
    while (stage.run(10ms) == Status::running) {
        const double speed = units::deg(stage.player.targets()[0]->velocity_rad_s);
        EXPECT_GE(speed, before - 400.0 * 0.0101);
        before = speed;
    }
    EXPECT_EQ(stage.player.next(stage.now, stage.states), Status::stopped);
    // v/2 times (v/a + a/j): half a second on.
    EXPECT_NEAR(stage.shown[0] - where, 50.0 * (0.25 + 0.1), 2.1);
    EXPECT_EQ(stage.player.targets()[0]->velocity_rad_s, 0.0);
}

TEST(SequencePlayer, ALateLoopDelaysTheMotionInsteadOfLettingItLeap)
{
    Stage stage(R"({pose = "ready"})");
    stage.run(600ms);
    stage.longest_leap_deg = 0.0;
    stage.now += 10s; // something kept the program busy
    EXPECT_EQ(stage.player.next(stage.now, stage.states), Status::running);
    stage.follow();
    EXPECT_LE(stage.longest_leap_deg, 100.0 * 0.0501);
    EXPECT_EQ(stage.player.delayed(), 10s + 10ms - 50ms);
    EXPECT_EQ(stage.run(), Status::done);
}

TEST(SequencePlayer, ACallThatWaitsDoesNotGoOn)
{
    Stage stage(R"({pose = "ready"})");
    stage.run(600ms);
    const double there = stage.shown[0];
    stage.player.wait();
    stage.run(10ms);
    EXPECT_EQ(stage.shown[0], there);
    EXPECT_EQ(stage.player.delayed(), 10ms);
    stage.run(10ms);
    EXPECT_GT(stage.shown[0], there);
}

TEST(SequencePlayer, AConditionIsWaitedFor)
{
    Stage stage(R"({until = {joint = "wrist", position_above_deg = 10, within_s = 5}}, {move = {elbow_deg = 1}})");
    EXPECT_EQ(stage.run(2s), Status::running);
    EXPECT_FALSE(stage.player.targets()[0]);
    stage.states[1].position_rad = {units::rad(11.0), stage.now};
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_LT(stage.elapsed_s(), 3.0);
}

TEST(SequencePlayer, AConditionThatIsNotMetEndsTheSequenceWithWhatWasSeen)
{
    Stage stage(R"({until = {joint = "wrist", position_above_deg = 10, within_s = 2}}, {move = {elbow_deg = 1}})");
    stage.states[1].position_rad = {units::rad(4.0), stage.now + 1s};
    EXPECT_EQ(stage.run(), Status::failed);
    EXPECT_NEAR(stage.elapsed_s(), 2.0, 0.021);
    EXPECT_EQ(stage.player.error().code, Errc::timeout);
    EXPECT_EQ(to_sentence(stage.player.error()),
              "r.toml:21:1: the position of wrist was not above 10 deg within 2 s; it was 4 deg");
    EXPECT_FALSE(stage.player.targets()[0]);
}

TEST(SequencePlayer, ATimeOutMayBeToldToGoOn)
{
    Stage stage(
        R"({until = {joint = "wrist", current_above_a = 1, within_s = 2, on_timeout = "continue"}}, {move = {elbow_deg = 1}})");
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_GT(stage.elapsed_s(), 2.0);
    EXPECT_DOUBLE_EQ(stage.shown[0], 1.0);
}

TEST(SequencePlayer, WhatWasMeasuredBeforeTheStepDoesNotCount)
{
    Stage stage(R"({wait_s = 1}, {until = {joint = "wrist", current_above_a = 1, within_s = 2}})");
    stage.states[1].current_a = {3.0, stage.now};
    EXPECT_EQ(stage.run(), Status::failed);
    EXPECT_EQ(to_sentence(stage.player.error()),
              "r.toml:21:15: the current of wrist was not above 1 A within 2 s; it was not measured");
}

TEST(SequencePlayer, AMoveUntilSomethingIsTouchedEndsThere)
{
    Stage stage(
        R"({move = {elbow_deg = 90}, speed = 0.5, until = {joint = "elbow", current_above_a = 0.4, within_s = 5}}, {move = {wrist_deg = 1}})");
    while (stage.shown[0] < 40.0)
        stage.run(10ms);
    stage.states[0].current_a = {-0.6, stage.now}; // its size counts
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_GT(stage.shown[0], 40.0);
    EXPECT_LT(stage.shown[0], 60.0);
    EXPECT_DOUBLE_EQ(stage.shown[1], 1.0);
}

TEST(SequencePlayer, AMoveThatArrivesKeepsWaitingForItsCondition)
{
    Stage stage(R"({move = {elbow_deg = 5}, until = {joint = "elbow", current_above_a = 0.4, within_s = 5}})");
    EXPECT_EQ(stage.run(), Status::failed);
    EXPECT_NEAR(stage.elapsed_s(), 5.0, 0.021);
    EXPECT_DOUBLE_EQ(stage.shown[0], 5.0);
}

TEST(SequencePlayer, ASpeedHasNoSign)
{
    Stage stage(R"({until = {joint = "wrist", speed_below_deg_s = 1, within_s = 5}})");
    stage.states[1].velocity_rad_s = {-1.0, stage.now + 1h};
    EXPECT_EQ(stage.run(1s), Status::running);
    stage.states[1].velocity_rad_s = {-0.001, stage.now + 1h};
    EXPECT_EQ(stage.run(), Status::done);
}

TEST(SequencePlayer, NothingAsksTheHeapWhileItPlays)
{
    Stage stage(
        R"({repeat = 3, steps = [{pose = "ready"}, {call = "nod"}, {pose = "rest", duration_s = 2}, {wait_s = 0.1}]})");
    const auto before = support::allocations();
    EXPECT_EQ(stage.run(), Status::done);
    EXPECT_EQ(support::allocations(), before);
}

TEST(SequencePlayer, APoseIsASequenceOfOneMove)
{
    Stage stage(R"({wait_s = 1})");
    const auto sequence = sequence_of(*stage.file.find_pose("ready"), {.duration_s = 3.0});
    SequencePlayer player(stage.file, sequence);
    TimePoint now{};
    while (player.next(now, stage.states) == Status::running)
        now += 10ms;
    EXPECT_EQ(now.time_since_epoch(), 3s);
    EXPECT_DOUBLE_EQ(units::deg(player.targets()[0]->position_rad), 90.0);
}

} // namespace
} // namespace sinew::robot
