#include "sinew/base/units.hpp"
#include "sinew/family/rmd/group.hpp"
#include "tests/scenario/robot.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/random.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

/// Every mode of a driver against a simulated device.
namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using actuator::Command;
using actuator::Depth;
using actuator::Mode;

constexpr std::string_view three = R"(
version = 1
[bus.s]
family = "sam"
[bus.n]
family = "nuri"
bit_rate = 115200
[bus.r]
family = "rmd"
[joint.servo]
bus = "s"
id = 1
model = "SAM-160EO200"
[joint.servo.profile_options]
response_level = 1
[joint.turner]
bus = "n"
id = 1
[joint.motor]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
[joint.motor.profile_options]
torque_constant_nm_per_a = 1.5
)";

const ResolvedJoint& joint_of(const Robot& robot, std::string_view name)
{
    for (const auto& joint : robot.resolved().joints)
        if (joint.joint->name == name)
            return joint;
    ADD_FAILURE() << name;
    return robot.resolved().joints.front();
}

// ---- moves in a time ----

TEST(Modes, AMoveWithADurationArrivesInThatTime)
{
    for (const auto& [name, ramps] : {std::pair{"turner", 0ms}, {"motor", 300ms}}) {
        Robot robot(robot_file(three));
        const auto& joint = joint_of(robot, name);
        const auto before = robot.read(joint, Depth::full);
        const double target = *before.position_rad + units::rad(60);
        robot.command(joint, {.mode = Mode::position, .position_rad = target, .duration = 2s}, before);
        robot.wait(1s);
        EXPECT_NEAR(units::deg(robot.look(name).position_rad - *before.position_rad), 30.0, 2.0) << name;
        robot.wait(700ms);
        EXPECT_LT(units::deg(robot.look(name).position_rad - *before.position_rad), 59.5) << name << ": not earlier";
        robot.wait(350ms + ramps);
        EXPECT_NEAR(units::deg(robot.look(name).position_rad - *before.position_rad), 60.0, 0.1) << name;
    }
}

// ---- current, torque, duty ----

TEST(Modes, ACurrentDrivesInItsSenseAndIsMeasuredAsItWasAsked)
{
    for (const double sense : {1.0, -1.0}) {
        Robot robot(robot_file(three));
        const auto& motor = joint_of(robot, "motor");
        robot.command(motor, {.mode = Mode::current, .current_a = sense * 1.0});
        robot.wait(100ms);
        const auto state = robot.read(motor, Depth::full);
        EXPECT_GT(sense * robot.look("motor").velocity_rad_s, 0.0);
        EXPECT_GT(sense * *state.velocity_rad_s, 0.0);
        EXPECT_NEAR(*state.current_a, sense, 0.05);
        EXPECT_NEAR(robot.look("motor").current_a, sense, 0.05);
    }
}

TEST(Modes, ATorqueIsTheCurrentThatGivesIt)
{
    Robot robot(robot_file(three));
    const auto& motor = joint_of(robot, "motor");
    robot.command(motor, {.mode = Mode::torque, .torque_nm = 1.5});
    robot.wait(100ms);
    EXPECT_NEAR(robot.look("motor").current_a, 1.0, 0.05);
}

TEST(Modes, ADutyTurnsAWheelInItsSense)
{
    for (const double sense : {1.0, -1.0}) {
        Robot robot(robot_file(three));
        const auto& servo = joint_of(robot, "servo");
        robot.command(servo, {.mode = Mode::duty, .duty = sense * 0.3});
        robot.wait(500ms);
        EXPECT_GT(sense * robot.look("servo").velocity_rad_s, 0.0);
        EXPECT_EQ(robot.look("servo").mode, "wheel");
        robot.command(servo, {.mode = Mode::hold}, robot.read(servo, Depth::motion));
        robot.wait(1s);
        EXPECT_NEAR(robot.look("servo").velocity_rad_s, 0.0, 1e-6);
    }
}

TEST(Modes, ABrakeBrakesAndTheNextMoveFreesIt)
{
    for (const std::string_view line : {"lk-2.35", "lk-2.36", "myactuator-3"}) {
        Robot robot(robot_file(fmt::format("version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.motor]\nbus = \"r\"\n"
                                           "id = 1\nmodel = \"MG\"\nprofile = \"{}\"\n",
                                           line)));
        const auto& motor = robot.resolved().joints[0];
        robot.command(motor, {.mode = Mode::brake});
        EXPECT_EQ(robot.look("motor").mode, "brake") << line;
        robot.command(motor, {.mode = Mode::position, .position_rad = 0.5, .velocity_rad_s = 1.0},
                      robot.read(motor, Depth::full));
        robot.wait(2s);
        EXPECT_NEAR(robot.look("motor").position_rad, 0.5, 0.001) << line;
    }
    Robot robot(robot_file(three));
    const auto& servo = joint_of(robot, "servo");
    robot.command(servo, {.mode = Mode::brake});
    EXPECT_EQ(robot.look("servo").mode, "brake");
}

TEST(Modes, ATorqueGroupDrivesEachMotorWithItsOwnCurrent)
{
    Robot robot(robot_file(R"(
version = 1
[bus.r]
family = "rmd"
[joint.a]
bus = "r"
id = 1
model = "MG"
[joint.b]
bus = "r"
id = 2
model = "MG"
[joint.c]
bus = "r"
id = 4
model = "MG"
)"));
    const double currents[] = {1.0, -2.0, 0.5};
    std::vector<rmd::GroupMember> members;
    for (std::size_t i = 0; i < 3; ++i)
        members.push_back({dynamic_cast<rmd::Driver*>(&robot.driver(robot.resolved().joints[i].joint->name)),
                           {.mode = Mode::current, .current_a = currents[i]}});
    const auto plan = rmd::plan_group(members);
    ASSERT_TRUE(plan.has_value()) << to_sentence(plan.error());
    bus::Result result;
    ASSERT_TRUE(robot.line("r").exchange(plan->all(), {&result, 1}).has_value());
    ASSERT_EQ(result.reply_count, 3);
    robot.wait(20ms);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& name = robot.resolved().joints[i].joint->name;
        EXPECT_NEAR(robot.look(name).current_a, currents[i], 0.05) << name;
        actuator::State state;
        for (const auto& reply : result.replies)
            if (reply.size != 0) {
                ASSERT_TRUE(robot.driver(name).absorb(plan->all()[0], reply, result.at, state).has_value());
            }
        EXPECT_TRUE(state.temperature_c) << name << " found its own answer";
    }
}

// ---- the shaft that is counted, and the output ----

TEST(Modes, AGearedMotorGoesToTheAngleOfItsOutput)
{
    Robot robot(robot_file(R"(
version = 1
[bus.r]
family = "rmd"
[joint.motor]
bus = "r"
id = 1
model = "MG"
profile = "lk-2.35"
[joint.motor.profile_options]
gear_ratio = 6
)"));
    const auto& motor = robot.resolved().joints[0];
    robot.command(motor, {.mode = Mode::position, .position_rad = units::rad(30), .velocity_rad_s = units::rad(60)},
                  robot.read(motor, Depth::full));
    robot.wait(2s);
    EXPECT_NEAR(units::deg(robot.look("motor").position_rad), 180.0, 0.1) << "the simulated shaft is the counted one";
    EXPECT_NEAR(units::deg(*robot.read(motor, Depth::motion).position_rad), 30.0, 0.01);
}

// ---- the shortest messages ----

TEST(Modes, ACoarseMoveGoesByQuickMessagesAndArrives)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints) {
        if (joint.family->name != "sam")
            continue;
        auto state = robot.read(joint, Depth::motion);
        const double target = *state.position_rad + units::rad(21.6);
        const Command go{.mode = Mode::position, .position_rad = target, .resolution_rad = units::rad(2)};
        EXPECT_LE(robot.cycle(joint, go, state), 2U);
        robot.wait(1s);
        robot.cycle(joint, go, state);
        EXPECT_NEAR(robot.look(joint.joint->name).position_rad, target, units::rad(1.1)) << joint.joint->name;
        EXPECT_NEAR(*state.position_rad, target, units::rad(1.7)) << joint.joint->name;
    }
}

// ---- control loops ----

TEST(Modes, ALoopBringsAFreshStateOfEveryJointAndAsksTheHeapForNothing)
{
    Robot robot(demo());
    std::vector<actuator::State> states;
    std::vector<double> start;
    for (const auto& joint : robot.resolved().joints) {
        states.push_back(robot.read(joint, Depth::full));
        start.push_back(*states.back().position_rad);
    }
    constexpr int cycles = 100;
    std::uint64_t before = 0;
    std::size_t requests_of_rmd = 0;
    for (int i = 0; i < cycles; ++i) {
        if (i == 5)
            before = support::allocations();
        for (std::size_t j = 0; j < states.size(); ++j) {
            const auto& joint = robot.resolved().joints[j];
            const bool has_limit = robot.driver(joint.joint->name).capabilities().velocity_limit;
            Command go{.mode = Mode::position, .position_rad = start[j] + units::rad(0.2 * i)};
            if (has_limit)
                go.velocity_rad_s = units::rad(90);
            const TimePoint begin = robot.now();
            const auto requests = robot.cycle(joint, go, states[j]);
            if (i >= 80 && joint.family->name == "rmd")
                requests_of_rmd += requests;
            if (states[j].position_rad.at() < begin)
                FAIL() << joint.joint->name << " has an old position in cycle " << i;
        }
        // Nuri's line takes most of the cycle; the others wait for it here, not in a robot.
        robot.wait(1ms);
    }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_LE(requests_of_rmd, 20U * 6U + 6U) << "one exchange each, by the encoder";
    for (std::size_t j = 0; j < states.size(); ++j) {
        const auto& name = robot.resolved().joints[j].joint->name;
        EXPECT_NEAR(*states[j].position_rad, robot.look(name).position_rad, units::rad(1.0)) << name;
    }
    for (const auto* line : {"left", "waist", "legs"})
        EXPECT_EQ(robot.weather(line).timeouts + robot.weather(line).strays, 0U) << line;
}

TEST(Modes, APositionCarriedOnByTheVelocityIsNearerToTheTruth)
{
    Robot robot(robot_file(three));
    for (const auto* name : {"turner", "motor"}) {
        const auto& joint = joint_of(robot, name);
        robot.command(joint, {.mode = Mode::velocity, .velocity_rad_s = units::rad(90)},
                      robot.read(joint, Depth::full));
        robot.wait(2s);
        const auto state = robot.read(joint, Depth::full);
        robot.wait(40ms);
        const double truth = robot.look(name).position_rad;
        const auto carried = state.position_rad_at(robot.now());
        ASSERT_TRUE(carried) << name;
        EXPECT_GT(std::abs(*state.position_rad - truth), units::rad(3)) << name;
        EXPECT_LT(std::abs(*carried - truth), units::rad(0.7)) << name;
    }
}

// ---- sign and magnitude ----

TEST(Modes, ANuriNeverTellsAWrongSignHoweverItTurns)
{
    Random random("Modes.ANuriNeverTellsAWrongSignHoweverItTurns");
    for (const std::string_view limit : {"clamp", "wrap"}) {
        Robot robot(
            robot_file(fmt::format("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.turner]\n"
                                   "bus = \"n\"\nid = 1\n[joint.turner.profile_options]\n"
                                   "position_feedback_limit = \"{}\"\n",
                                   limit)));
        const auto& turner = robot.resolved().joints[0];
        actuator::State state = robot.read(turner, Depth::full);
        int told = 0, beyond = 0;
        constexpr int looks = 400;
        for (int i = 0; i < looks; ++i) {
            // To and fro at first, then far out: what is told beyond the range of a feedback is looked at, too.
            const bool goes_back = i < looks / 2 && random.one_in(3);
            const double deg_s = (goes_back ? -1.0 : 1.0) * static_cast<double>(30 + random.below(330));
            if (i % 20 == 0)
                robot.command(turner, {.mode = Mode::velocity, .velocity_rad_s = units::rad(deg_s), .duration = 100ms});
            robot.wait(std::chrono::milliseconds(random.below(150)));
            const double truth_before = robot.look("turner").position_rad;
            state = {};
            const auto depth = random.one_in(2) ? Depth::full : Depth::motion;
            robot.run(turner, *robot.driver("turner").plan_read(depth), state);
            const auto truth = robot.look("turner");
            const double moved = std::abs(truth.position_rad - truth_before) + units::rad(0.2);
            if (state.position_rad) {
                ASSERT_NEAR(*state.position_rad, truth.position_rad, moved) << limit << ' ' << i << " seed " << seed();
                ++told;
                beyond += std::abs(*state.position_rad) > units::rad(660) ? 1 : 0;
            }
            if (state.velocity_rad_s && std::abs(truth.velocity_rad_s) > units::rad(20)) {
                ASSERT_GT(*state.velocity_rad_s * truth.velocity_rad_s, 0.0) << limit << ' ' << i << " seed " << seed();
            }
        }
        EXPECT_GT(told, looks * 3 / 4) << limit;
        EXPECT_GT(beyond, 10) << limit << " seed " << seed();
    }
}

} // namespace
} // namespace sinew::test
