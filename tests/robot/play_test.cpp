#include "sinew/robot/play.hpp"

#include "sinew/robot/pose.hpp"
#include "tests/robot/rig.hpp"

#include <array>
#include <gtest/gtest.h>
#include <map>
#include <utility>

/// Poses, sequences and synchronised moves of simulated robots.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;
using Status = SequencePlayer::Status;

std::string said(const std::expected<Status, Error>& result)
{
    return result ? std::string() : to_sentence(result.error());
}

constexpr std::string_view pair = R"(
version = 1
[bus.left]
family = "sam"
[bus.legs]
family = "rmd"
[joint.elbow]
bus = "left"
id = 3
model = "SAM-160EO200"
position_min_deg = -5
position_max_deg = 140
velocity_max_deg_s = 120
[joint.knee]
bus = "legs"
id = 2
model = "MG"
profile = "rmd-2.35"
velocity_max_deg_s = 180
[pose.up]
elbow_deg = 80
knee_deg = 90
[pose.down]
elbow_deg = 0
knee_deg = 0
)";

config::RobotFile pair_with(std::string_view steps)
{
    return file_of(std::string(pair) + "[sequence.test]\nsteps = [" + std::string(steps) + "]\n");
}

TEST(Play, TheSequenceOfTheDemoRobotPlaysToItsEnd)
{
    Rig rig(demo());
    rig.enable();
    std::map<std::string, double> furthest_deg;
    PlayOptions options;
    options.each = [&](const SequencePlayer&) {
        for (const auto* joint : {"elbow", "shoulder_pitch", "wrist_yaw", "neck_yaw"})
            furthest_deg[joint] = std::max(furthest_deg[joint], std::abs(units::deg(rig.truth_rad(joint))));
    };
    const TimePoint begun = rig.now();
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("wave"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_EQ(*played, Status::done);
    EXPECT_NEAR(furthest_deg["elbow"], 90.0, 1.0);
    EXPECT_NEAR(furthest_deg["shoulder_pitch"], 60.0, 1.0);
    EXPECT_NEAR(furthest_deg["wrist_yaw"], 25.0, 1.0);
    EXPECT_NEAR(furthest_deg["neck_yaw"], 20.0, 1.0);
    for (const config::JointTarget& target : rig.robot->file().find_pose("stand")->targets) {
        const Joint& joint = rig.robot->joints()[target.joint];
        EXPECT_NEAR(units::deg(rig.truth_rad(joint)), units::deg(target.position_rad), 0.6) << joint.name();
    }
    EXPECT_LT(rig.now() - begun, 20s);
    EXPECT_TRUE(rig.robot->incidents().empty()) << rig.robot->incidents()[0].says;
    EXPECT_TRUE(rig.robot->enabled());
}

TEST(Play, JointsOfAllFamiliesArriveTogether)
{
    Rig rig(demo());
    rig.enable();
    const std::array<NamedTarget, 3> targets{
        {{"elbow", units::rad(90)}, {"waist_yaw", units::rad(45)}, {"left_knee", units::rad(60)}}};
    std::map<std::string, TimePoint> arrived;
    PlayOptions options;
    options.each = [&](const SequencePlayer&) {
        for (const auto& target : targets)
            if (std::abs(rig.truth_rad(target.joint) - target.position_rad) > units::rad(1.0))
                arrived[target.joint] = rig.now();
    };
    const TimePoint begun = rig.now();
    const auto moved = move(*rig.robot, targets, {}, options);
    ASSERT_TRUE(moved) << said(moved);
    // The waist is the slowest: 45 degrees at 60 deg/s.
    for (const auto& target : targets) {
        EXPECT_NEAR(units::deg(rig.truth_rad(target.joint)), units::deg(target.position_rad), 0.6) << target.joint;
        EXPECT_NEAR(seconds(arrived[target.joint] - begun), 45.0 / 57.0 + 0.35, 0.25) << target.joint;
    }
}

TEST(Play, AStreamedMotionStaysBelowTheLimitsOfItsJoint)
{
    Rig rig(pair_with(R"({pose = "up"}, {pose = "down"})"));
    rig.enable();
    double fastest = 0.0;
    PlayOptions options;
    options.each = [&](const SequencePlayer&) { fastest = std::max(fastest, std::abs(rig.truth_rad_s("elbow"))); };
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_LT(units::deg(fastest), 120.0 * 1.1);
    EXPECT_GT(units::deg(fastest), 100.0);
}

TEST(Play, ALateLoopLeavesJointsBehindForAMomentAndGoesOn)
{
    Rig rig(pair_with(R"({pose = "up"}, {pose = "down"})"));
    rig.enable();
    PlayOptions options;
    int turns = 0;
    double fastest = 0.0;
    options.each = [&](const SequencePlayer&) {
        // Between the target and its sending, and now and then for longer than a step may be counted.
        rig.simulator->clock().wait({}, rig.now() + (++turns % 7 == 0 ? 120ms : 8ms));
        fastest = std::max(fastest, std::abs(rig.truth_rad_s("elbow")));
    };
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_EQ(*played, Status::done);
    EXPECT_NEAR(units::deg(rig.truth_rad("elbow")), 0.0, 0.6);
    EXPECT_LT(units::deg(fastest), 120.0 * 1.3);
}

TEST(Play, SmallStepsMakeAMotionLongerForAllJoints)
{
    auto file = pair_with(R"({pose = "up"})");
    file.joints[0].step_max_rad = units::rad(0.5); // 50 deg/s
    Rig rig(file);
    rig.enable();
    PlayOptions options;
    Duration delayed{};
    double most = 0.0;
    options.each = [&](const SequencePlayer& player) {
        delayed = player.delayed();
        const double elbow = rig.truth_rad("elbow") / units::rad(80), knee = rig.truth_rad("knee") / units::rad(90);
        most = std::max(most, std::abs(elbow - knee));
    };
    const TimePoint begun = rig.now();
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_NEAR(units::deg(rig.truth_rad("elbow")), 80.0, 0.6);
    EXPECT_GT(seconds(rig.now() - begun), 80.0 / 50.0);
    EXPECT_GT(delayed, 400ms);
    EXPECT_LT(most, 0.2) << "they go together";
}

TEST(Play, AStopThatIsAskedForWhileTheJointsSettleIsHeard)
{
    Rig rig(pair_with(R"({pose = "up"})"));
    rig.enable();
    PlayOptions options;
    int turns = 0, asked = 0;
    options.each = [&](const SequencePlayer&) { ++turns; };
    options.stop_asked = [&] { return ++asked > turns + 1; }; // nothing is shown any more while they settle
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_EQ(*played, Status::stopped);
}

TEST(Play, AStopSlowsDownAndLeavesTheRobotHolding)
{
    Rig rig(pair_with(R"({repeat = "forever", steps = [{pose = "up"}, {pose = "down"}]})"));
    rig.enable();
    PlayOptions options;
    const TimePoint stop_at = rig.now() + 500ms;
    options.stop_asked = [&] { return rig.now() >= stop_at; };
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_TRUE(played) << said(played);
    EXPECT_EQ(*played, Status::stopped);
    EXPECT_LT(rig.now() - stop_at, 600ms);
    const double there = rig.truth_rad("elbow");
    EXPECT_GT(units::deg(there), 5.0);
    EXPECT_LT(units::deg(there), 79.0);
    ASSERT_TRUE(rig.run(500ms));
    EXPECT_NEAR(rig.truth_rad("elbow"), there, units::rad(0.6));
    EXPECT_TRUE(rig.robot->enabled());
}

TEST(Play, AGripperThatMeetsSomethingStopsThere)
{
    auto file = file_of(R"(
version = 1
[bus.left]
family = "sam"
[joint.elbow]
bus = "left"
id = 3
model = "SAM-160EO200"
velocity_max_deg_s = 60
[joint.elbow.plant]
stop_max_deg = 40
[sequence.grip]
steps = [{move = {elbow_deg = 90}, speed = 0.5, until = {joint = "elbow", current_above_a = 1, within_s = 5}}]
)");
    Rig rig(file);
    rig.enable();
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("grip"));
    ASSERT_TRUE(played) << said(played);
    EXPECT_EQ(*played, Status::done);
    EXPECT_NEAR(units::deg(rig.truth_rad("elbow")), 40.0, 2.0);
    EXPECT_LT(units::deg(*rig.robot->find("elbow")->command().position_rad), 70.0);
}

TEST(Play, AConditionThatIsNeverMetIsAnErrorWithItsPlace)
{
    Rig rig(pair_with(R"({until = {joint = "elbow", position_above_deg = 10, within_s = 1}}, {pose = "up"})"));
    rig.enable();
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"));
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().code, Errc::timeout);
    EXPECT_EQ(to_sentence(played.error()).substr(0, 16), "robot.toml:27:10") << to_sentence(played.error());
    EXPECT_NEAR(rig.truth_rad("elbow"), 0.0, 0.01);
}

TEST(Play, AFaultOfAJointEndsTheSequenceAndStopsTheRobot)
{
    Rig rig(pair_with(R"({repeat = "forever", steps = [{pose = "up"}, {pose = "down"}]})"));
    rig.enable();
    PlayOptions options;
    bool pulled = false;
    const TimePoint pull_at = rig.now() + 400ms;
    options.each = [&](const SequencePlayer&) {
        if (!pulled && rig.now() >= pull_at) {
            rig.inject(sim::FaultKind::unplug, "elbow");
            pulled = true;
        }
    };
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_FALSE(played);
    EXPECT_FALSE(rig.robot->enabled());
    EXPECT_NE(to_sentence(played.error()).find("elbow"), std::string::npos) << to_sentence(played.error());
}

/// One that waited for the joint to catch up would never end.
TEST(Play, AJointThatIsTooHotInTheMiddleOfAMotionEndsThePlayWithTheReason)
{
    for (const bool whole_robot : {true, false}) {
        auto file = pair_with(R"({pose = "up"}, {pose = "down"}, {pose = "up"})");
        file.safety.whole_robot = whole_robot;
        file.safety.temperature_max_c = 60.0;
        Rig rig(file);
        rig.enable();
        PlayOptions options;
        const TimePoint begun = rig.now();
        bool heated = false;
        options.each = [&](const SequencePlayer&) {
            if (!heated && rig.now() - begun > 300ms)
                rig.inject(sim::FaultKind::hot_motor, "knee");
            heated = rig.now() - begun > 300ms;
        };
        options.stop_asked = [&] {
            if (rig.now() - begun > 20s)
                rig.robot->request_stop(); // or a play that hangs would hang this test
            return false;
        };
        const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
        ASSERT_FALSE(played) << whole_robot;
        EXPECT_NE(said(played).find("80 °C hot, 60 °C are allowed"), std::string::npos) << said(played);
        EXPECT_LT(rig.now() - begun, 5s);
        EXPECT_NEAR(rig.truth_rad_s("knee"), 0.0, 0.01);
        EXPECT_NEAR(rig.truth_rad_s("elbow"), 0.0, 0.01);
        EXPECT_EQ(rig.robot->enabled(), !whole_robot);
    }
}

struct Freed {
    std::string said;
    double blocked_at_deg = 0.0, there_deg = 0.0, furthest_ahead_deg = 0.0;
    Duration took{};
    bool is_enabled = false;
    Mode ends_with = Mode::position;
};

/// One joint on its way from 0 to 80 deg at no more than 60 deg/s, its gear stuck for a while from the middle on.
Freed play_with_a_stuck_gear(std::string_view device, Duration stuck_for, std::string_view policy = "hold")
{
    Rig rig(file_of(fmt::format("version = 1\n[bus.b]\n{}id = 3\n"
                                "position_min_deg = -5\nposition_max_deg = 140\n"
                                "velocity_max_deg_s = 60\nstep_max_deg = 5\n[pose.up]\njoint_deg = 80\n"
                                "[safety]\npolicy = \"{}\"\n",
                                device, policy)));
    rig.enable();
    const TimePoint begun = rig.now();
    const auto passed = [&] { return rig.now() - begun; };
    Freed out;
    bool is_stuck = false;
    PlayOptions options;
    options.each = [&](const SequencePlayer&) {
        if (!std::exchange(is_stuck, is_stuck || passed() > 600ms) && is_stuck) {
            rig.inject(sim::FaultKind::stuck_gear, "joint", seconds(stuck_for));
            out.blocked_at_deg = units::deg(rig.truth_rad("joint"));
        }
        const auto& sent = rig.robot->find("joint")->command().position_rad;
        const double ahead = sent ? units::deg(*sent - rig.truth_rad("joint")) : 0.0;
        out.furthest_ahead_deg = std::max(out.furthest_ahead_deg, ahead);
    };
    out.said = said(play(*rig.robot, sequence_of(*rig.robot->file().find_pose("up")), options));
    out.took = passed();
    out.ends_with = rig.robot->find("joint")->command().mode;
    bool goes_on = !out.said.empty();
    while (goes_on && passed() < 600ms + stuck_for + 1s) {
        const auto ran = rig.run(5ms);
        goes_on = ran.has_value();
        EXPECT_TRUE(goes_on) << sinew::robot::test::said(ran);
    }
    out.there_deg = units::deg(rig.truth_rad("joint"));
    out.is_enabled = rig.robot->enabled();
    return out;
}

constexpr std::string_view a_sam = "family = \"sam\"\n[joint.joint]\nbus = \"b\"\nmodel = \"SAM-160EO200\"\n";
constexpr std::string_view an_rmd =
    "family = \"rmd\"\n[joint.joint]\nbus = \"b\"\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n";
constexpr std::string_view a_nuri = "family = \"nuri\"\nbit_rate = 115200\n[joint.joint]\nbus = \"b\"\n";

TEST(Play, AJointThatWasStuckIsNotLedOnAndDoesNotLeapWhenItComesFree)
{
    for (const auto device : {a_sam, an_rmd}) {
        const Freed freed = play_with_a_stuck_gear(device, 800ms);
        EXPECT_EQ(freed.said, "");
        EXPECT_NEAR(freed.there_deg, 80.0, 0.6) << "the motion has waited";
        EXPECT_GT(freed.took, 2300ms) << "it takes 1.6 s without";
        // 0.12 s of 60 deg/s, 5 deg, and the age of a measurement; led on for 0.8 s it would be 48.
        EXPECT_LT(freed.furthest_ahead_deg, 12.2 + 1.0) << device;
        EXPECT_TRUE(freed.is_enabled);
    }
}

TEST(Play, AJointThatStaysStuckEndsThePlayAndStaysWhereItIs)
{
    for (const auto device : {a_sam, an_rmd, a_nuri}) {
        const Freed freed = play_with_a_stuck_gear(device, 1800ms);
        EXPECT_NE(freed.said.find("does not follow"), std::string::npos) << device << freed.said;
        EXPECT_LT(freed.took, 3s) << "stuck for good it would be the same";
        // The loop of an RMD lets go of what it has gathered.
        EXPECT_NEAR(freed.there_deg, freed.blocked_at_deg, 2.0) << device;
        EXPECT_TRUE(freed.is_enabled);
    }
}

TEST(Play, AServoThatStaysStuckDoesWhatThePolicySaysAlsoInAPlay)
{
    for (const auto policy : {Mode::release, Mode::brake, Mode::hold})
        EXPECT_EQ(play_with_a_stuck_gear(a_sam, 1800ms, to_word(policy)).ends_with, policy) << to_word(policy);
}

TEST(Play, AServoWhoseSupplyFailedForAMomentEndsThePlayAndDoesNotLeapBack)
{
    auto file = pair_with(R"({pose = "up"}, {wait_s = 1}, {pose = "down"})");
    file.joints[0].stop_time_s = 0.2;
    Rig rig(file);
    rig.enable();
    PlayOptions options;
    const TimePoint begun = rig.now();
    bool cut = false;
    double lowest = units::rad(80);
    options.each = [&](const SequencePlayer&) {
        lowest = std::min(lowest, cut ? rig.truth_rad("elbow") : lowest);
        if (!cut && rig.now() - begun > 1500ms) {
            rig.inject(sim::FaultKind::power_cut, "elbow", 0.2);
            sim::Fault push{.kind = sim::FaultKind::push, .joint = "elbow", .for_s = 0.2};
            push.torque_nm = -5.0;
            rig.simulator->world().inject(push);
            cut = true;
        }
    };
    const auto played = play(*rig.robot, *rig.robot->file().find_sequence("test"), options);
    ASSERT_FALSE(played);
    EXPECT_NE(said(played).find("elbow did not answer for 0."), std::string::npos) << said(played);
    EXPECT_LT(units::deg(lowest), 60.0) << "it was pushed from 80 deg";
    EXPECT_LT(units::deg(rig.truth_rad("elbow") - lowest), 12.0);
    EXPECT_TRUE(rig.robot->enabled());
    EXPECT_EQ(rig.robot->find("elbow")->command().mode, Mode::hold);
    EXPECT_NEAR(rig.truth_rad_s("knee"), 0.0, 0.01);
}

TEST(Play, AMoveSaysWhatIsWrongBeforeAnythingMoves)
{
    Rig rig(pair_with(R"({wait_s = 1})"));
    rig.enable();
    const auto complaint = [&](std::vector<NamedTarget> targets, std::optional<Duration> duration = {}) {
        return said(move(*rig.robot, targets, duration));
    };
    EXPECT_EQ(complaint({{"knee", 0.1}, {"elbwo", 1.0}}), "the robot has no joint 'elbwo', did you mean elbow?");
    EXPECT_NE(complaint({{"knee", 0.1}, {"elbow", 9.0}}).find("140"), std::string::npos);
    EXPECT_EQ(complaint({{"knee", 0.1}, {"knee", 0.2}}), "knee can only go to one place at a time");
    EXPECT_NE(complaint({{"knee", 3.0}}, 100ms).find("knee: this motion cannot take 0.1 s; it can take 1."),
              std::string::npos);
    EXPECT_NEAR(rig.truth_rad("knee"), 0.0, 0.01);
    EXPECT_EQ(complaint({}), "");
    EXPECT_EQ(said(play(*rig.robot, *rig.robot->file().find_sequence("test"), {.speed = 0.0})),
              "the speed of a sequence is a share above 0 up to 1");
}

TEST(Play, AtAThirdOfTheSpeedAPoseTakesThreeTimesAsLong)
{
    Rig rig(pair_with(R"({wait_s = 1})"));
    rig.enable();
    const TimePoint begun = rig.now();
    ASSERT_TRUE(play(*rig.robot, sequence_of(*rig.robot->file().find_pose("up"))));
    const TimePoint there = rig.now();
    ASSERT_TRUE(play(*rig.robot, sequence_of(*rig.robot->file().find_pose("down")), {.speed = 1.0 / 3.0}));
    EXPECT_NEAR(seconds(rig.now() - there) / seconds(there - begun), 3.0, 0.3);
    EXPECT_NEAR(rig.truth_rad("knee"), 0.0, 0.02);
}

} // namespace
} // namespace sinew::robot::test
