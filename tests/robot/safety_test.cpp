#include "sinew/family/sam/messages.hpp"
#include "sinew/sim/fault.hpp"
#include "tests/robot/rig.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

/// Limits and stops hold whatever the program does.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view knee_text = R"(
version = 1
[bus.r]
family = "rmd"
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
position_min_deg = -10
position_max_deg = 100
velocity_max_deg_s = 180
)";

std::string with_safety(std::string_view keys)
{
    return fmt::format("{}[safety]\n{}\n", knee_text, keys);
}

TEST(Safety, NothingIsCommandedBeforeEnable)
{
    Rig rig(file_of(knee_text));
    const auto set = rig.robot->set("knee", {.mode = Mode::position, .position_rad = 0.1});
    ASSERT_FALSE(set.has_value());
    EXPECT_FALSE(rig.robot->cycle().has_value());
    EXPECT_TRUE(rig.robot->state("knee")->position_rad.has_value()) << "but it is read";
}

TEST(Safety, WhatIsBeyondALimitIsRefusedWithASentence)
{
    Rig rig(file_of(knee_text));
    rig.enable();
    for (const Command& command :
         {Command{.mode = Mode::position, .position_rad = units::rad(101)},
          Command{.mode = Mode::position, .position_rad = units::rad(-11)},
          Command{.mode = Mode::position, .position_rad = std::nan("")},
          Command{.mode = Mode::position, .position_rad = 0.1, .velocity_rad_s = units::rad(181)},
          Command{.mode = Mode::position, .position_rad = units::rad(90), .duration = 100ms},
          Command{.mode = Mode::velocity, .velocity_rad_s = units::rad(181)}, Command{.mode = Mode::torque}}) {
        const auto set = rig.robot->set("knee", command);
        ASSERT_FALSE(set.has_value());
        EXPECT_NE(said(set).find("knee"), std::string::npos) << said(set);
    }
    EXPECT_EQ(rig.robot->find("knee")->command().mode, Mode::hold) << "the command before stays";
}

TEST(Safety, AStreamThatIsFasterThanItsLimitIsRefusedAndNeverSent)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.servo]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-20\"\nvelocity_max_deg_s = 60\n"));
    rig.enable();
    Joint& servo = *rig.robot->find("servo");
    double sent = *servo.state().position_rad;
    int refused = 0;
    for (int i = 1; i <= 100; ++i) {
        const double wish = sent + units::rad(i % 2 == 0 ? 0.55 : 3.0); // 55 and 300 deg/s at 10 ms
        if (servo.set({.mode = Mode::position, .position_rad = wish}))
            sent = wish;
        else
            ++refused;
        ASSERT_TRUE(rig.run(10ms));
        EXPECT_LE(*servo.command().position_rad, sent + 1e-9);
    }
    EXPECT_EQ(refused, 50);
    EXPECT_NEAR(rig.truth_rad("servo"), sent, units::rad(3));
    const auto jump = servo.set({.mode = Mode::position, .position_rad = sent - units::rad(30)});
    ASSERT_FALSE(jump.has_value());
    EXPECT_NE(said(jump).find("60.00 deg/s"), std::string::npos) << said(jump);
}

TEST(Safety, AJointThatTurnsWithoutEndHoldsBeforeItsLimit)
{
    Rig rig(file_of(knee_text));
    rig.enable();
    Joint& knee = *rig.robot->find("knee");
    ASSERT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(120)}));
    for (int i = 0; i < 200; ++i) {
        ASSERT_TRUE(rig.run(10ms));
        EXPECT_LT(units::deg(rig.truth_rad("knee")), 100.0);
    }
    EXPECT_EQ(knee.command().mode, Mode::hold);
    EXPECT_GT(units::deg(rig.truth_rad("knee")), 85.0);
    ASSERT_EQ(rig.robot->incidents().size(), 1U);
    EXPECT_NE(rig.robot->incidents()[0].says.find("limit"), std::string::npos);
    EXPECT_FALSE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(160)}));
    EXPECT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(-60)})) << "back is allowed";
}

TEST(Safety, ACommandStreamThatDriesUpEndsByThePolicy)
{
    for (const std::string_view policy : {"hold", "release"}) {
        Rig rig(file_of(with_safety(fmt::format("policy = \"{}\"\ncommand_timeout_s = 0.2", policy))));
        rig.enable();
        Joint& knee = *rig.robot->find("knee");
        for (int i = 0; i < 30; ++i) {
            ASSERT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(30)}));
            ASSERT_TRUE(rig.run(10ms));
        }
        EXPECT_EQ(knee.command().mode, Mode::velocity);
        ASSERT_TRUE(rig.run(300ms));
        EXPECT_EQ(to_word(knee.command().mode), policy);
        ASSERT_FALSE(rig.robot->incidents().empty());
        EXPECT_NE(rig.robot->incidents()[0].says.find("no command"), std::string::npos);
        EXPECT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(30)})) << "the next one counts";
    }
}

TEST(Safety, ACommandStreamThatDriesUpBrakesAServoWhereThePolicySaysSo)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n"
                    "[safety]\npolicy = \"brake\"\ncommand_timeout_s = 0.2\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::velocity, .velocity_rad_s = units::rad(30)})), "");
    ASSERT_EQ(said(rig.run(500ms)), "");
    EXPECT_EQ(rig.simulator->world().look("arm")->mode, "brake");
    EXPECT_NEAR(rig.truth_rad_s("arm"), 0.0, 1e-3);
}

TEST(Safety, AJointThatFallsSilentStopsTheOthers)
{
    Rig rig(demo());
    rig.enable();
    Joint& knee = *rig.robot->find("left_knee");
    ASSERT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(20)}));
    ASSERT_TRUE(rig.run(500ms));
    rig.inject(sim::FaultKind::unplug, "elbow");
    const auto ran = rig.run(2s);
    ASSERT_FALSE(ran.has_value());
    EXPECT_NE(said(ran).find("elbow"), std::string::npos) << said(ran);
    EXPECT_FALSE(rig.robot->enabled());
    ASSERT_NE(rig.robot->fault(), nullptr);
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
    EXPECT_FALSE(knee.set({.mode = Mode::hold}));
    EXPECT_FALSE(rig.robot->enable().has_value()) << "the elbow is still unplugged";
    rig.simulator->world().mend("elbow");
    rig.simulator->clock().wait({}, rig.now() + 200ms);
    rig.enable();
    EXPECT_TRUE(knee.set({.mode = Mode::hold}));
}

TEST(Safety, ALostLinkStopsTheOtherBuses)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = units::rad(20)}));
    ASSERT_TRUE(rig.robot->set("waist_yaw", {.mode = Mode::velocity, .velocity_rad_s = units::rad(20)}));
    ASSERT_TRUE(rig.run(500ms));
    EXPECT_GT(rig.truth_rad_s("left_knee"), 0.2);
    ASSERT_TRUE(rig.simulator->set_plugged("left", false));
    const auto ran = rig.run(2s);
    ASSERT_FALSE(ran.has_value());
    EXPECT_EQ(ran.error().code, Errc::link_lost) << said(ran);
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
    EXPECT_NEAR(rig.truth_rad_s("waist_yaw"), 0.0, 0.02);
    ASSERT_TRUE(rig.simulator->set_plugged("left", true));
    rig.enable();
    EXPECT_TRUE(rig.run(200ms).has_value());
}

TEST(Safety, ALinkLostAmidACycleStopsASlowerBusWithItsNextFrame)
{
    std::string text = "version = 1\n";
    for (const std::string bus : {"a", "b"}) {
        text += fmt::format("[bus.{}]\nfamily = \"nuri\"\nbit_rate = 9600\n", bus);
        for (int id = 1; id <= 4; ++id)
            text += fmt::format("[joint.{}{}]\nbus = \"{}\"\nid = {}\nmodel = \"RSA\"\n", bus, id, bus, id);
    }
    Rig rig(file_of(text));
    rig.enable();
    for (const auto* joint : {"b1", "b2", "b3", "b4"})
        ASSERT_EQ(said(rig.robot->set(joint, {.mode = Mode::velocity, .velocity_rad_s = 0.1})), "");
    ASSERT_EQ(said(rig.robot->cycle()), "");
    // What leaves for the slower bus in a cycle with whose first request the plug of the other is pulled.
    constexpr std::uint8_t ask_for_feedback = 0xA1;
    std::vector<std::uint8_t> commands;
    rig.robot->buses()[1]->set_tap([&](const bus::Tapped& tapped) {
        if (tapped.verdict != bus::Verdict::sent)
            return;
        commands.push_back(tapped.bytes[5]);
        if (commands.size() == 1) {
            EXPECT_TRUE(rig.simulator->set_plugged("a", false));
        }
    });
    EXPECT_EQ(rig.robot->cycle().error().code, Errc::link_lost);
    ASSERT_GE(commands.size(), 5U);
    EXPECT_EQ(std::ranges::count(std::span(commands).first(5), ask_for_feedback), 0)
        << "the states of its four joints were still asked for before they were stopped";
}

TEST(Safety, AnArmThatWasMovedByHandWhileItsLinkWasLostDoesNotLeapBack)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-160EO200\"\nposition_min_deg = -150\nposition_max_deg = 150\n"));
    rig.enable();
    ASSERT_TRUE(rig.run(200ms));
    ASSERT_TRUE(rig.simulator->set_plugged("s", false));
    EXPECT_FALSE(rig.run(1s).has_value());
    // It has lost its torque and is pushed away.
    rig.simulator->world().find_device("arm")->power_cycle();
    sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.3};
    push.torque_nm = 2.0;
    rig.simulator->world().inject(push);
    rig.simulator->clock().wait({}, rig.now() + 5s);
    const double pushed = rig.truth_rad("arm");
    ASSERT_GT(std::abs(pushed), units::rad(3.0));
    ASSERT_TRUE(rig.simulator->set_plugged("s", true));
    for (int i = 0; i < 200; ++i) {
        static_cast<void>(rig.robot->cycle());
        rig.simulator->clock().wait({}, rig.now() + 5ms);
    }
    EXPECT_NEAR(units::deg(rig.truth_rad("arm")), units::deg(pushed), 3.0);
    EXPECT_LT(seconds(rig.robot->state("arm")->age(rig.now())), 0.1) << "a link that is back is read";
}

TEST(Safety, ADeviceThatStartedAfreshIsSetUpAgainAndHoldsWhereItIs)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.servo]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-20\"\nvelocity_max_deg_s = 60\n[joint.servo.runtime]\np_gain = 77\nd_gain = 5\n"));
    rig.enable();
    ASSERT_TRUE(rig.robot->set("servo", {.mode = Mode::position, .position_rad = 0.5, .velocity_rad_s = 0.2}));
    ASSERT_TRUE(rig.run(1s));
    rig.simulator->world().find_device("servo")->power_cycle();
    const auto ran = rig.run(3s);
    ASSERT_TRUE(ran.has_value()) << said(ran);
    ASSERT_EQ(rig.robot->incidents().size(), 1U);
    EXPECT_NE(rig.robot->incidents()[0].says.find("afresh"), std::string::npos) << rig.robot->incidents()[0].says;
    EXPECT_EQ(rig.robot->find("servo")->command().mode, Mode::hold);
    const auto gains = rig.robot->buses()[0]->call(1, sam::ReadPdGain{});
    ASSERT_TRUE(gains.has_value());
    EXPECT_EQ(gains->p_gain, 77);
    EXPECT_LT(rig.truth_rad("servo"), 0.49) << "it did not go on";
}

/// No gain is set, so that nothing that it forgot could show it.
TEST(Safety, AnArmWhoseSupplyFailedForAMomentDoesNotLeapBackFromWhereItSagged)
{
    for (const std::string_view level : {"0", "1"}) {
        Rig rig(file_of(fmt::format("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.elbow]\nbus = \"s\"\nid = 3\n"
                                    "model = \"SAM-160EO200\"\nvelocity_max_deg_s = 240\n"
                                    "[joint.elbow.profile_options]\nresponse_level = {}\n"
                                    "[joint.elbow.plant]\nexternal_torque_nm = -5\n",
                                    level)));
        rig.enable();
        Joint& elbow = *rig.robot->find("elbow");
        ASSERT_TRUE(elbow.set({.mode = Mode::position, .position_rad = units::rad(60), .velocity_rad_s = 1.0}));
        ASSERT_TRUE(rig.run(2s));
        ASSERT_GT(rig.truth_rad("elbow"), units::rad(55));
        ASSERT_TRUE(rig.robot->incidents().empty());
        rig.inject(sim::FaultKind::power_cut, "elbow", 0.2);
        double lowest = rig.truth_rad("elbow"), back_to = 0.0;
        for (int i = 0; i < 200; ++i) {
            const auto ran = rig.run(10ms);
            ASSERT_TRUE(ran.has_value()) << said(ran);
            const double at = rig.truth_rad("elbow");
            if (at < lowest)
                lowest = back_to = at;
            back_to = std::max(back_to, at);
        }
        EXPECT_LT(lowest, units::rad(40)) << "it has sagged";
        // It fell while it was looked at, and swings back from where its fall was stopped.
        EXPECT_LT(units::deg(back_to - lowest), 12.0) << level;
        EXPECT_EQ(elbow.command().mode, Mode::hold);
        EXPECT_EQ(elbow.overruled(), 1U);
        ASSERT_EQ(rig.robot->incidents().size(), 1U);
        EXPECT_NE(rig.robot->incidents()[0].says.find("may have started afresh"), std::string::npos)
            << rig.robot->incidents()[0].says;
        const auto back = elbow.set({.mode = Mode::position, .position_rad = units::rad(60)});
        EXPECT_FALSE(back.has_value()) << "a stream goes on from where it is";
    }
}

TEST(Safety, AServoThatIsStuckIsNotWalkedOnAndItsWalkEndsWithAnIncident)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.elbow]\nbus = \"s\"\nid = 3\n"
                    "model = \"SAM-160EO200\"\nvelocity_max_deg_s = 60\n"));
    rig.enable();
    Joint& elbow = *rig.robot->find("elbow");
    ASSERT_TRUE(elbow.set({.mode = Mode::position, .position_rad = 1.5, .velocity_rad_s = units::rad(50)}));
    ASSERT_TRUE(rig.run(500ms));
    const double blocked_at = rig.truth_rad("elbow");
    rig.inject(sim::FaultKind::stuck_gear, "elbow", 0.8);
    ASSERT_TRUE(rig.run(3s));
    EXPECT_NEAR(rig.truth_rad("elbow"), 1.5, units::rad(0.2)) << "it goes on when it is free";
    EXPECT_TRUE(rig.robot->incidents().empty());
    ASSERT_TRUE(elbow.set({.mode = Mode::position, .position_rad = blocked_at, .velocity_rad_s = units::rad(50)}));
    ASSERT_TRUE(rig.run(500ms));
    rig.inject(sim::FaultKind::stuck_gear, "elbow", 2.0);
    ASSERT_TRUE(rig.run(100ms));
    const double stuck_at = rig.truth_rad("elbow");
    ASSERT_TRUE(rig.run(3s));
    EXPECT_NEAR(rig.truth_rad("elbow"), stuck_at, units::rad(0.5));
    EXPECT_EQ(elbow.command().mode, Mode::hold);
    ASSERT_EQ(rig.robot->incidents().size(), 1U);
    EXPECT_NE(rig.robot->incidents()[0].says.find("does not follow"), std::string::npos)
        << rig.robot->incidents()[0].says;
}

TEST(Safety, AJointThatWasReleasedStaysFreeAfterASilence)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.servo]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-20\"\n"));
    rig.enable();
    ASSERT_TRUE(rig.robot->set("servo", {.mode = Mode::release}));
    ASSERT_TRUE(rig.run(100ms));
    rig.inject(sim::FaultKind::power_cut, "servo", 0.2);
    ASSERT_TRUE(rig.run(1s));
    EXPECT_EQ(rig.robot->incidents().size(), 1U);
    EXPECT_EQ(rig.robot->find("servo")->command().mode, Mode::release);
    EXPECT_EQ(rig.simulator->world().look("servo")->mode, "passive");
}

TEST(Safety, AHotMotorStopsTheRobot)
{
    Rig rig(file_of(with_safety("temperature_max_c = 60")));
    rig.enable();
    ASSERT_TRUE(rig.run(100ms));
    rig.inject(sim::FaultKind::hot_motor, "knee");
    const auto ran = rig.run(2s);
    ASSERT_FALSE(ran.has_value());
    EXPECT_NE(said(ran).find("°C"), std::string::npos) << said(ran);
}

TEST(Safety, AnExceptionThatLeavesTheScopeOfARobotStopsItAndANormalEndDoesNot)
{
    for (const bool throws : {true, false}) {
        Rig rig(file_of(knee_text));
        rig.enable();
        ASSERT_TRUE(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = units::rad(30)}));
        ASSERT_TRUE(rig.run(300ms));
        const auto speed = [&] { return units::deg(rig.simulator->world().look("knee")->velocity_rad_s); };
        ASSERT_GT(speed(), 25.0);
        try {
            const auto robot = std::move(rig.robot);
            if (throws)
                throw std::runtime_error("a bug of the program");
        } catch (const std::runtime_error& bug) {
            EXPECT_STREQ(bug.what(), "a bug of the program");
        }
        rig.simulator->clock().wait({}, rig.now() + 200ms);
        EXPECT_NEAR(speed(), throws ? 0.0 : 30.0, 1.0);
    }
}

} // namespace
} // namespace sinew::robot::test
