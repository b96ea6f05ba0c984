#include "tests/robot/lossy_can.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <utility>

/// A robot that is enabled when somebody enables it, or when a link that it lost is back.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Enable, AnEnabledRobotThatCannotBeEnabledAnewStandsStill)
{
    auto file = demo();
    file.safety.whole_robot = false;
    Rig rig(file);
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = 0.3})), "");
    ASSERT_EQ(said(rig.run(300ms)), "");
    rig.inject(sim::FaultKind::unplug, "elbow");
    ASSERT_EQ(said(rig.run(1s)), "") << "it goes on without the elbow";
    ASSERT_GT(rig.truth_rad_s("left_knee"), 0.2);
    EXPECT_NE(said(rig.robot->enable()).find("elbow"), std::string::npos);
    EXPECT_FALSE(rig.robot->enabled());
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
    ASSERT_NE(rig.robot->fault(), nullptr);
}

TEST(Enable, WhatTurnsStandsStillWhileItsRobotIsEnabledAnew)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = 0.3})), "");
    ASSERT_EQ(said(rig.run(300ms)), "");
    rig.enable();
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
    EXPECT_EQ(rig.robot->find("left_knee")->command().mode, Mode::hold);
}

TEST(Enable, AStopThatWasAskedForOfAnEnabledRobotIsCarriedOutAndTheNextEnableGoesOn)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = 0.3})), "");
    ASSERT_EQ(said(rig.run(300ms)), "");
    rig.robot->request_stop();
    const auto on = rig.robot->enable();
    ASSERT_FALSE(on);
    EXPECT_EQ(on.error().code, Errc::stopped);
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
    rig.enable();
    EXPECT_EQ(said(rig.run(100ms)), "");
}

/// It cannot hear its stop while its link is lost. Nor may it turn on until everything else is well.
TEST(Enable, AMotorWhoseLinkWasLostWhenItWasStoppedHearsOfThatFirst)
{
    Rig rig(file_of("version = 1\n[safety]\npolicy = \"hold\"\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[bus.r]\n"
                    "family = \"rmd\"\n[joint.waist]\nbus = \"n\"\nid = 1\n[joint.knee]\nbus = \"r\"\nid = 1\n"
                    "model = \"MG\"\nprofile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("knee", {.mode = Mode::velocity, .velocity_rad_s = 0.3})), "");
    ASSERT_EQ(said(rig.run(300ms)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("r", false));
    EXPECT_NE(said(rig.run(1s)), "");
    EXPECT_NE(said(rig.robot->enable()), "") << "it is not back";
    rig.inject(sim::FaultKind::unplug, "waist");
    ASSERT_TRUE(rig.simulator->set_plugged("r", true));
    ASSERT_GT(rig.truth_rad_s("knee"), 0.2);
    EXPECT_NE(said(rig.robot->enable()).find("waist"), std::string::npos);
    rig.simulator->clock().wait({}, rig.now() + 500ms);
    EXPECT_NEAR(rig.truth_rad_s("knee"), 0.0, 1e-3);
}

/// Which nobody asked for, so nobody hears what it returns.
TEST(Enable, AJointThatDidNotConfirmTheStopForAFaultIsAnIncident)
{
    auto file = demo();
    for (auto& joint : file.joints)
        if (joint.name == "elbow")
            joint.plant.push_back({"viscous_friction_nm_s_per_rad", 1000.0, {}});
    Rig rig(file);
    rig.enable();
    sim::Fault load{.kind = sim::FaultKind::push, .joint = "elbow"};
    load.torque_nm = -28.0;
    rig.simulator->world().inject(load);
    ASSERT_EQ(said(rig.run(300ms)), "");
    rig.inject(sim::FaultKind::unplug, "left_hip");
    EXPECT_NE(said(rig.run(3s)), "");
    std::vector<std::string> told;
    for (const auto& incident : rig.robot->incidents())
        if (incident.says.find("did not confirm the stop") != std::string::npos)
            told.push_back(incident.joint);
    EXPECT_EQ(told, (std::vector<std::string>{"elbow", "left_hip"}));
}

/// A person had to be asked.
TEST(Enable, AnEnabledRobotThatWasAskedNothingForAWhileIsNotStoppedByThat)
{
    auto file = demo();
    file.safety.policy = config::Policy::release;
    Rig rig(file);
    rig.enable();
    ASSERT_EQ(said(rig.run(100ms)), "");
    rig.simulator->clock().wait({}, rig.now() + 3s);
    rig.enable();
    for (const auto& incident : rig.robot->incidents())
        EXPECT_EQ(incident.says.find("stopped"), std::string::npos) << incident.says;
}

TEST(Enable, AMotorOfABusThatIsBackIsStoppedAlthoughAnotherBusIsNot)
{
    std::string text = "version = 1\n[safety]\npolicy = \"hold\"\n";
    for (const auto* name : {"a", "b"})
        text += fmt::format("[bus.{0}]\nfamily = \"rmd\"\n[joint.on_{0}]\nbus = \"{0}\"\nid = 1\nmodel = \"MG\"\n"
                            "profile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n",
                            name);
    for (const auto* back : {"a", "b"}) {
        Rig rig(file_of(text));
        rig.enable();
        for (const auto* joint : {"on_a", "on_b"})
            ASSERT_EQ(said(rig.robot->set(joint, {.mode = Mode::velocity, .velocity_rad_s = 0.3})), "");
        ASSERT_EQ(said(rig.run(300ms)), "");
        for (const auto* bus : {"a", "b"})
            ASSERT_TRUE(rig.simulator->set_plugged(bus, false));
        EXPECT_NE(said(rig.run(1s)), "");
        ASSERT_TRUE(rig.simulator->set_plugged(back, true));
        EXPECT_NE(said(rig.robot->enable()), "");
        rig.simulator->clock().wait({}, rig.now() + 500ms);
        EXPECT_NEAR(rig.truth_rad_s(fmt::format("on_{}", back)), 0.0, 1e-3) << back;
    }
}

/// Two motors that hold, each on a bus of its own.
const std::string knee_and_waist = [] {
    std::string text = "version = 1\n[safety]\npolicy = \"hold\"\n";
    for (const auto& [joint, id] : {std::pair{"knee", 1}, std::pair{"waist", 2}})
        text += fmt::format("[bus.of_{0}]\nfamily = \"rmd\"\n[joint.{0}]\nbus = \"of_{0}\"\nid = {1}\nmodel = \"MG\"\n"
                            "profile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n",
                            joint, id);
    return text;
}();
constexpr std::uint32_t knee_identifier = 0x141;
constexpr std::uint8_t speed_closed_loop = 0xA2;

double turns_at(LossyRobot& one)
{
    return std::abs(one.simulator->world().look("knee")->velocity_rad_s);
}

enum class Then { read, enable }; ///< which fails, for the waist is not there

void go_on(LossyRobot& one, Then then)
{
    if (then == Then::read) {
        for (int i = 0; i < 50; ++i) {
            EXPECT_FALSE(one.robot->cycle());
            one.simulator->clock().wait({}, one.simulator->clock().now() + 10ms);
        }
    } else {
        one.simulator->world().inject({.kind = sim::FaultKind::unplug, .joint = "waist"});
        EXPECT_NE(said(one.robot->enable()).find("waist"), std::string::npos);
    }
    one.simulator->clock().wait({}, one.simulator->clock().now() + 500ms);
}

/// The first one that went out when its link was back was lost.
TEST(Enable, AStopThatAMotorDidNotAcknowledgeWhenItsLinkWasBackIsStillOwed)
{
    for (const Then then : {Then::read, Then::enable}) {
        LossyRobot one(knee_and_waist);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.3}, 300ms)), "");
        ASSERT_TRUE(one.simulator->set_plugged("of_knee", false));
        EXPECT_NE(said(one.robot->wait(1s, 10ms)), "");
        ASSERT_TRUE(one.simulator->set_plugged("of_knee", true));
        one.losses.of_sent = [](const wire::Frame& frame) { return frame.can_id == knee_identifier; };
        if (then == Then::enable) {
            EXPECT_NE(said(one.robot->enable()), "");
        } else {
            one.simulator->clock().wait({}, one.simulator->clock().now() + 200ms);
            EXPECT_FALSE(one.robot->cycle());
        }
        ASSERT_GT(turns_at(one), 0.2) << "it has heard nothing";
        one.losses.of_sent = [](const wire::Frame&) { return false; };
        go_on(one, then);
        EXPECT_NEAR(turns_at(one), 0.0, 1e-3) << static_cast<int>(then);
    }
}

/// Its adapter was there all the time.
TEST(Enable, AMotorWhoseOwnCableWasOutWhenItWasStoppedHearsOfThatOnceItIsBack)
{
    for (const Then then : {Then::read, Then::enable}) {
        LossyRobot one(knee_and_waist);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.3}, 300ms)), "");
        one.losses.of_sent = [](const wire::Frame& frame) { return frame.can_id == knee_identifier; };
        EXPECT_NE(said(one.robot->wait(2s, 10ms)), "");
        ASSERT_GT(turns_at(one), 0.2);
        one.losses.of_sent = [](const wire::Frame&) { return false; };
        go_on(one, then);
        EXPECT_NEAR(turns_at(one), 0.0, 1e-3) << static_cast<int>(then);
    }
}

/// Whether it has been asked for.
std::shared_ptr<bool> ask_with_the_next_frame(LossyRobot& one)
{
    auto asked = std::make_shared<bool>(false);
    one.losses.of_sent = [&one, asked](const wire::Frame&) {
        if (!std::exchange(*asked, true))
            one.robot->request_stop();
        return false;
    };
    return asked;
}

TEST(Enable, AStopThatIsAskedForWhileLinksComeBackIsNotForgotten)
{
    LossyRobot one(knee_and_waist);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.3}, 300ms)), "");
    ASSERT_TRUE(one.simulator->set_plugged("of_knee", false));
    EXPECT_NE(said(one.robot->wait(1s, 10ms)), "");
    ASSERT_TRUE(one.simulator->set_plugged("of_knee", true));
    const auto asked = ask_with_the_next_frame(one);
    const auto on = one.robot->enable();
    ASSERT_TRUE(*asked);
    ASSERT_FALSE(on);
    EXPECT_EQ(on.error().code, Errc::stopped);
    EXPECT_EQ(said(one.robot->enable()), "");
}

/// It is not what that enable fails for.
TEST(Enable, AStopThatIsAskedForInAnEnableThatFailsOtherwiseIsToldByTheNext)
{
    LossyRobot one(knee_and_waist);
    for (const auto* bus : {"of_knee", "of_waist"})
        ASSERT_TRUE(one.simulator->set_plugged(bus, false));
    EXPECT_NE(said(one.robot->wait(1s, 10ms)), "");
    ASSERT_TRUE(one.simulator->set_plugged("of_knee", true));
    const auto asked = ask_with_the_next_frame(one);
    EXPECT_EQ(one.robot->enable().error().code, Errc::link_lost);
    ASSERT_TRUE(*asked);
    ASSERT_TRUE(one.simulator->set_plugged("of_waist", true));
    const auto on = one.robot->enable();
    ASSERT_FALSE(on);
    EXPECT_EQ(on.error().code, Errc::stopped);
    EXPECT_EQ(said(one.robot->enable()), "");
}

/// Its feedback ends at 6553.3 deg.
TEST(Enable, AWheelThatHasTurnedTooFarToTellWhereItIsCanBeEnabledAgain)
{
    Rig rig(
        file_of("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.wheel]\nbus = \"n\"\nid = 1\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("wheel", {.mode = Mode::velocity, .velocity_rad_s = 10.0})), "");
    ASSERT_EQ(said(rig.run(20s)), "");
    ASSERT_GT(rig.truth_rad("wheel"), units::rad(6600));
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    EXPECT_NEAR(rig.truth_rad_s("wheel"), 0.0, 1e-3);
}

/// Every other one would hold with torque, and nobody would look after it.
TEST(Enable, ARobotOfWhichOneJointDidNotConfirmToHoldIsStopped)
{
    auto text = knee_and_waist;
    LossyRobot one(text.replace(text.find("hold"), 4, "release"));
    (void)one.robot->stop();
    sim::Fault push{.kind = sim::FaultKind::push, .joint = "knee"};
    push.torque_nm = 1.0;
    bool lost = false;
    one.losses.of_heard = [&](const wire::Frame& frame) {
        return frame.data[0] == speed_closed_loop && frame.can_id == knee_identifier + 1 && !std::exchange(lost, true);
    };
    EXPECT_NE(said(one.robot->enable()).find("waist"), std::string::npos);
    EXPECT_FALSE(one.robot->enabled());
    one.simulator->world().inject(push);
    one.simulator->clock().wait({}, one.simulator->clock().now() + 300ms);
    EXPECT_GT(turns_at(one), 0.2) << "it is free";
}

TEST(Enable, ARobotThatWasNeverEnabledIsStoppedByThePolicyOfItsFile)
{
    const auto file = file_of("version = 1\n[safety]\npolicy = \"hold\"\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\n"
                              "bus = \"r\"\nid = 1\nmodel = \"MG\"\nprofile = \"rmd-2.35\"\n[joint.knee.plant]\n"
                              "gravity_torque_nm = 3\ngravity_zero_deg = 90\n");
    Rig rig(file);
    rig.enable();
    ASSERT_EQ(said(rig.run(100ms)), "");
    const double held = rig.truth_rad("knee");
    rig.robot.reset();
    auto second = Robot::open(file, links_of(*rig.simulator), rig.simulator->clock(), {.simulated = true});
    ASSERT_TRUE(second);
    EXPECT_EQ(second->stop().front().did, Mode::hold);
    rig.simulator->clock().wait({}, rig.now() + 1s);
    EXPECT_NEAR(units::deg(Mounting::of(file.joints[0]).to_joint(rig.simulator->world().look("knee")->position_rad)),
                units::deg(held), 2.0)
        << "it falls";
}

TEST(Enable, ARobotThatIsNotEnabledIsStillReadAfterAStopWasAskedFor)
{
    Rig rig(demo());
    rig.robot->request_stop();
    rig.simulator->clock().wait({}, rig.now() + 10ms);
    EXPECT_EQ(said(rig.robot->read()), "");
    EXPECT_TRUE(rig.robot->find("elbow")->state().position_rad);
    const auto on = rig.robot->enable();
    ASSERT_FALSE(on) << "whoever asked for it is not overruled by a reading";
    EXPECT_EQ(on.error().code, Errc::stopped);
    rig.enable();
}

/// Its bus ends what runs on the others, which answer all the same.
TEST(Enable, TheBusThatIsLostIsNamedAndNotTheJointsOfTheOthers)
{
    LossyRobot one(knee_and_waist);
    ASSERT_EQ(said(one.robot->wait(100ms, 10ms)), "");
    one.simulator->clock().wait({}, one.simulator->clock().now() + 3s);
    ASSERT_TRUE(one.simulator->set_plugged("of_waist", false));
    EXPECT_NE(said(one.robot->enable()).find("of_waist"), std::string::npos) << said(one.robot->enable());
    ASSERT_NE(one.robot->fault(), nullptr);
    EXPECT_EQ(one.robot->fault()->code, Errc::link_lost);
}

/// A Nuri keeps its switch in its flash.
TEST(Enable, ANuriIsNotWornByBeingEnabledAndReleased)
{
    Rig rig(
        file_of("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.waist]\nbus = \"n\"\nid = 1\n"));
    auto writes = [&, before = std::uint64_t{0}]() mutable {
        const auto all = rig.simulator->world().flash_writes();
        return all - std::exchange(before, all);
    };
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    EXPECT_EQ(writes(), 0U) << "it says that it is on";
    ASSERT_EQ(said(rig.robot->set("waist", {.mode = Mode::release})), "");
    ASSERT_EQ(said(rig.run(10s)), "");
    EXPECT_FALSE(*rig.robot->find("waist")->state().enabled);
    EXPECT_LE(writes(), 2U);
    ASSERT_EQ(said(rig.robot->set("waist", {.mode = Mode::hold})), "");
    ASSERT_EQ(said(rig.run(1s)), "");
    EXPECT_TRUE(*rig.robot->find("waist")->state().enabled);
    EXPECT_LE(writes(), 2U);
    ASSERT_EQ(said(rig.robot->set("waist", {.mode = Mode::release})), "");
    ASSERT_EQ(said(rig.run(1s)), "");
    EXPECT_LE(writes(), 2U);
    rig.enable();
    EXPECT_TRUE(*rig.robot->find("waist")->state().enabled);
    EXPECT_LE(writes(), 1U);
}

/// It comes up switched on, and a Nuri that holds cannot be moved by hand.
TEST(Enable, AReleasedNuriThatStartsAfreshIsReleasedAgain)
{
    Rig rig(
        file_of("version = 1\n[bus.n]\nfamily = \"nuri\"\nbit_rate = 115200\n[joint.waist]\nbus = \"n\"\nid = 1\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("waist", {.mode = Mode::release})), "");
    ASSERT_EQ(said(rig.run(2s)), "");
    rig.simulator->world().find_device("waist")->power_cycle();
    ASSERT_EQ(said(rig.run(2s)), "");
    EXPECT_FALSE(*rig.robot->find("waist")->state().enabled);
}

/// It was moved by hand while its link was lost, and is braked; another one of its line is not back yet.
TEST(Enable, AServoThatIsEnabledAgainAfterItsLinkWasLostDoesNotLeapToWhereItWas)
{
    std::string text = "version = 1\n[safety]\npolicy = \"hold\"\n[bus.s]\nfamily = \"sam\"\n";
    for (const auto& [name, id] : {std::pair{"arm", 1}, std::pair{"wrist", 2}})
        text += fmt::format("[joint.{0}]\nbus = \"s\"\nid = {1}\nmodel = \"SAM-20\"\n[joint.{0}.profile_options]\n"
                            "response_level = 1\n",
                            name, id);
    Rig rig(file_of(text));
    rig.enable();
    ASSERT_EQ(said(rig.run(100ms)), "");
    const double before = rig.truth_rad("arm");
    ASSERT_TRUE(rig.simulator->set_plugged("s", false));
    EXPECT_NE(said(rig.run(1s)), "");
    rig.inject(sim::FaultKind::unplug, "wrist");
    sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.3};
    push.torque_nm = 6.0;
    ASSERT_TRUE(rig.simulator->set_plugged("s", true));
    EXPECT_NE(said(rig.robot->enable()).find("wrist"), std::string::npos);
    rig.simulator->world().inject(push);
    rig.simulator->clock().wait({}, rig.now() + 1s);
    const double pushed = rig.truth_rad("arm");
    ASSERT_GT(std::abs(pushed - before), units::rad(2));
    EXPECT_NE(said(rig.robot->enable()).find("wrist"), std::string::npos);
    rig.simulator->clock().wait({}, rig.now() + 1s);
    EXPECT_NEAR(units::deg(rig.truth_rad("arm")), units::deg(pushed), 1.0);
}

TEST(Enable, TwoLinksThatComeBackTogetherAreNoStopThatSomebodyAskedFor)
{
    std::string text = "version = 1\n[safety]\npolicy = \"hold\"\n";
    for (const auto* name : {"a", "b"})
        text += fmt::format("[bus.{0}]\nfamily = \"rmd\"\n[joint.on_{0}]\nbus = \"{0}\"\nid = 1\nmodel = \"MG\"\n"
                            "profile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n",
                            name);
    for (const Duration since_a_try : {0ms, 30ms, 60ms, 90ms, 120ms}) {
        Rig rig(file_of(text));
        rig.enable();
        for (const auto* bus : {"a", "b"})
            ASSERT_TRUE(rig.simulator->set_plugged(bus, false));
        EXPECT_NE(said(rig.run(1s)), "");
        (void)rig.robot->cycle(); // which tries to open them
        rig.simulator->clock().wait({}, rig.now() + since_a_try);
        for (const auto* bus : {"a", "b"})
            ASSERT_TRUE(rig.simulator->set_plugged(bus, true));
        EXPECT_EQ(said(rig.robot->enable()), "") << since_a_try.count();
    }
}

} // namespace
} // namespace sinew::robot::test
