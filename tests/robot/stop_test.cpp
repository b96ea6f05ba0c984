#include "tests/robot/by_hand.hpp"
#include "tests/robot/lossy_can.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <iterator>
#include <utility>

/// A stop reaches every joint, whatever it does and whoever is not there.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

std::vector<std::string> names(std::span<const wire::Request> requests)
{
    std::vector<std::string> out;
    for (const auto& request : requests)
        out.push_back(fmt::format("{} to {}", request.message->name(), request.id));
    return out;
}

/// By the time that a guardian sends that, the place where it was measured is old.
TEST(Stop, AServoThatMustBeToldWhereToHoldIsToldNoPlaceThatIsOld)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[bus.n]\nfamily = \"nuri\"\n[joint.servo]\nbus = \"s\"\n"
                    "id = 1\nmodel = \"SAM-20\"\n[joint.waist]\nbus = \"n\"\nid = 1\n"));
    rig.enable();
    for (Joint& joint : rig.robot->joints())
        ASSERT_TRUE(joint.set({.mode = Mode::velocity, .velocity_rad_s = 0.5}));
    ASSERT_TRUE(rig.run(100ms));
    EXPECT_EQ(names(rig.robot->stop_requests(0)), std::vector<std::string>{"position-control to 1"});
    const std::vector<std::string> brakes{"quick-brake-mode to 31", "special-control to 1"};
    EXPECT_EQ(names(rig.robot->unseen_stop_requests(0)), brakes);
    EXPECT_EQ(names(rig.robot->unseen_stop_requests(1)), names(rig.robot->stop_requests(1))) << "it holds where it is";
    ASSERT_TRUE(rig.robot->set("servo", {.mode = Mode::release}));
    ASSERT_TRUE(rig.run(20ms));
    EXPECT_EQ(names(rig.robot->unseen_stop_requests(0)), names(rig.robot->stop_requests(0))) << "it was let go";
}

TEST(Stop, AServoThatWasMovedByHandWhileNobodyLookedDoesNotLeapBack)
{
    enum class Then { cycle, stop, hold };
    for (const auto& [then, cycles] :
         {std::pair{Then::cycle, 10}, {Then::stop, 10}, {Then::hold, 10}, {Then::stop, 1}, {Then::hold, 1}}) {
        Rig rig(file_of(servo_by_hand));
        rig.enable();
        ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::brake})), "");
        for (int i = 0; i < cycles; ++i) {
            ASSERT_EQ(said(rig.robot->cycle()), "");
            rig.simulator->clock().wait({}, rig.now() + 10ms);
        }
        const double before = rig.truth_rad("arm");
        guide_by_hand(*rig.simulator, then == Then::hold ? 400ms : 1s, 6.0);
        const double guided = rig.truth_rad("arm");
        ASSERT_GT(std::abs(guided - before), units::rad(3));
        double furthest = 0.0;
        const auto look = [&] { furthest = std::max(furthest, std::abs(rig.truth_rad("arm") - guided)); };
        if (then == Then::hold) {
            ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::hold})), "");
        }
        if (then == Then::stop)
            (void)rig.robot->stop();
        else
            (void)rig.robot->cycle();
        for (int i = 0; i < 100; ++i, look())
            if (then == Then::hold)
                (void)rig.run(10ms);
            else
                rig.simulator->clock().wait({}, rig.now() + 10ms);
        EXPECT_LT(units::deg(furthest), 2.0)
            << static_cast<int>(then) << " after " << cycles << ": it turns on a little when the hand lets go";
    }
}

/// Not to where it was, though that is where it is sent.
TEST(Stop, AServoThatWasMovedByHandWhileNobodyLookedIsLedFromWhereItIs)
{
    for (const bool at_once : {false, true})
        for (const int cycles : {1, 10}) {
            Rig rig(file_of(servo_by_hand + std::string("velocity_max_deg_s = 20\n")));
            rig.enable();
            ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::brake})), "");
            for (int i = 0; i < cycles; ++i) {
                ASSERT_EQ(said(rig.robot->cycle()), "");
                rig.simulator->clock().wait({}, rig.now() + 10ms);
            }
            const double before = *rig.robot->find("arm")->state().position_rad;
            guide_by_hand(*rig.simulator, 400ms, 6.0);
            const double guided = rig.truth_rad("arm");
            ASSERT_GT(std::abs(guided - before), units::rad(20));
            Command back{.mode = Mode::position, .position_rad = before};
            if (!at_once)
                back.velocity_rad_s = units::rad(20);
            ASSERT_EQ(said(rig.robot->set("arm", back)), "");
            ASSERT_EQ(said(rig.run(500ms)), "");
            const double way_deg = units::deg(std::abs(rig.truth_rad("arm") - guided));
            EXPECT_LT(way_deg, 12.0) << at_once << " after " << cycles;
            EXPECT_GT(way_deg, 5.0) << at_once << " after " << cycles << ": it goes there all the same";
        }
}

/// Which is no pause.
TEST(Stop, AStreamThatBeginsAtABrakedServoGoesOutAsItIs)
{
    Rig rig(file_of(servo_by_hand + std::string("velocity_max_deg_s = 60\n")));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::brake})), "");
    ASSERT_EQ(said(rig.run(100ms)), "");
    const double from = *rig.robot->find("arm")->state().position_rad;
    for (int i = 1; i <= 50; ++i) {
        ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::position, .position_rad = from + i * units::rad(0.55)})),
                  "")
            << i;
        ASSERT_EQ(said(rig.run(10ms)), "");
    }
}

/// It takes up to a second to look at all of them.
TEST(Stop, ManyServosOnABusThatIsReadSeldomAreAllLed)
{
    struct Seldom {
        int count, bit_rate;
        double rate_hz;
        bool double_read;
        Duration time;
    };
    for (const auto& [count, bit_rate, rate_hz, double_read, time] :
         {Seldom{16, 57600, 5, false, 5s}, Seldom{31, 4800, 0.25, true, 160s}}) {
        std::string text = fmt::format("version = 1\n[safety]\nsilence_max_s = 20\n[bus.s]\nfamily = \"sam\"\n"
                                       "bit_rate = {}\nrate_hz = {}\n",
                                       bit_rate, rate_hz);
        for (int id = 0; id < count; ++id)
            text +=
                fmt::format("[joint.j{0}]\nbus = \"s\"\nid = {0}\nmodel = \"SAM-20\"\nvelocity_max_deg_s = 60\n", id);
        bus::Settings settings;
        settings.double_read = double_read;
        Rig rig(file_of(text), settings);
        rig.enable();
        for (Joint& joint : rig.robot->joints())
            ASSERT_EQ(said(joint.set({.mode = Mode::position,
                                      .position_rad = *joint.state().position_rad + units::rad(15),
                                      .velocity_rad_s = units::rad(30)})),
                      "");
        std::vector<double> from;
        for (Joint& joint : rig.robot->joints())
            from.push_back(rig.truth_rad(joint));
        ASSERT_EQ(said(rig.run(time)), "");
        for (std::size_t i = 0; i < from.size(); ++i)
            EXPECT_NEAR(units::deg(rig.truth_rad(rig.robot->joints()[i]) - from[i]), 15.0, 1.0) << i << " of " << count;
    }
}

/// A program that waited too long for something, in the middle of a move.
TEST(Stop, AServoWhoseProgramPausedIsHeldAndNotBrakedForGood)
{
    Rig rig(file_of(
        "version = 1\n[safety]\npolicy = \"hold\"\ncommand_timeout_s = 0.2\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\n"
        "bus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::position, .position_rad = 0.3, .velocity_rad_s = 0.5})), "");
    ASSERT_EQ(said(rig.run(100ms)), "");
    rig.simulator->clock().wait({}, rig.now() + 300ms);
    ASSERT_EQ(said(rig.run(1s)), "");
    EXPECT_EQ(rig.robot->find("arm")->command().mode, Mode::hold);
    EXPECT_NE(rig.simulator->world().look("arm")->mode, "brake");
}

/// Which needs to be told where, and is on a line that was lost.
TEST(Stop, AServoThatOwesAStopIsHeldOnceItIsBackAndThenLeftAlone)
{
    Rig rig(file_of(servo_by_hand));
    rig.enable();
    ASSERT_EQ(said(rig.run(100ms)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("s", false));
    EXPECT_NE(said(rig.run(1s)), "");
    (void)rig.robot->stop();
    ASSERT_TRUE(rig.simulator->set_plugged("s", true));
    int told = 0;
    rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) { told += tapped.verdict == bus::Verdict::sent; });
    const auto read_for = [&](int cycles) {
        for (int i = 0; i < cycles; ++i) {
            (void)rig.robot->cycle();
            rig.simulator->clock().wait({}, rig.now() + 10ms);
        }
        return std::exchange(told, 0);
    };
    read_for(100);
    EXPECT_NE(rig.simulator->world().look("arm")->mode, "brake");
    EXPECT_LE(read_for(100), 110) << "it is only read";
}

/// Its answers are gone, it still hears: to hold where it was measured last would be a leap back.
TEST(Stop, AServoOfWhichNothingIsHeardDoesNotLeapBackWhenItIsStopped)
{
    Rig rig(
        file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[safety]\nsilence_max_s = 1.0\n[joint.servo]\nbus = \"s\"\n"
                "id = 1\nmodel = \"SAM-20\"\n"));
    rig.enable();
    ASSERT_TRUE(rig.robot->set("servo", {.mode = Mode::velocity, .velocity_rad_s = 1.0}));
    ASSERT_TRUE(rig.run(300ms));
    sim::Fault late{.kind = sim::FaultKind::delay_replies, .joint = "servo"};
    late.probability = 1.0;
    late.delay_s = 10.0;
    rig.simulator->world().inject(late);
    double furthest = rig.truth_rad("servo");
    while (rig.robot->enabled()) {
        (void)rig.robot->cycle();
        furthest = std::max(furthest, rig.truth_rad("servo"));
    }
    rig.simulator->clock().wait({}, rig.now() + 1s);
    EXPECT_GT(rig.truth_rad("servo"), furthest - units::rad(1.0));
    EXPECT_NEAR(rig.truth_rad_s("servo"), 0.0, 1e-3);
}

TEST(Stop, WhatStopsARobotIsReadyBeforeItsFirstCycle)
{
    const auto all_names = [](const Robot& robot) {
        std::vector<std::string> out;
        for (std::size_t bus = 0; bus < robot.buses().size(); ++bus)
            std::ranges::copy(names(robot.stop_requests(bus)), std::back_inserter(out));
        return out;
    };
    Rig rig(demo());
    rig.enable();
    const auto before = all_names(*rig.robot);
    EXPECT_GE(before.size(), rig.robot->joints().size());
    ASSERT_TRUE(rig.robot->cycle());
    EXPECT_EQ(before, all_names(*rig.robot)) << "a robot that holds was let go";
}

TEST(Stop, AStopReachesEveryJointAndSaysSo)
{
    for (const std::string_view policy : {"hold", "release", "brake"}) {
        auto file = demo();
        file.safety.policy = policy == "hold"      ? config::Policy::hold
                             : policy == "release" ? config::Policy::release
                                                   : config::Policy::brake;
        Rig rig(file);
        rig.enable();
        for (Joint& joint : rig.robot->joints()) {
            const double sense = joint.name().ends_with("hip") ? -1.0 : 1.0;
            const auto set = joint.set({.mode = Mode::velocity, .velocity_rad_s = sense * units::rad(30)});
            ASSERT_TRUE(set.has_value()) << said(set);
        }
        ASSERT_TRUE(rig.run(300ms));
        const auto stopped = rig.robot->stop();
        ASSERT_EQ(stopped.size(), 16U);
        for (const auto& one : stopped) {
            EXPECT_NE(one.outcome, Stopped::Outcome::failed) << one.joint << to_sentence(one.why);
            EXPECT_NEAR(rig.truth_rad_s(one.joint), 0.0, 0.05) << one.joint << " " << policy;
            if (one.did == Mode::hold) {
                EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed) << one.joint;
            }
        }
        EXPECT_FALSE(rig.robot->cycle().has_value());
        rig.enable();
    }
}

TEST(Stop, AStopGoesOnPastADeviceThatIsNotThere)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = units::rad(20)}));
    ASSERT_TRUE(rig.run(100ms));
    rig.inject(sim::FaultKind::unplug, "shoulder_pitch");
    for (const auto& one : rig.robot->stop())
        EXPECT_EQ(one.outcome == Stopped::Outcome::failed, one.joint == "shoulder_pitch") << one.joint;
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
}

/// Each look at it lasts until its time-outs are over, and while another joint comes to rest there are many looks.
TEST(Stop, AStopDoesNotWaitForADeviceThatIsNotThereAtEveryLookAtTheOthers)
{
    const auto time_to_stop = [](bool is_there) {
        bus::Settings patient;
        patient.margin_at_first = patient.margin_least = patient.margin_most = 500ms;
        auto file = demo();
        file.safety.policy = config::Policy::release; // no Nuri tells that it was released
        Rig rig(file, patient);
        rig.enable();
        EXPECT_TRUE(rig.run(100ms));
        if (!is_there)
            rig.inject(sim::FaultKind::unplug, "left_knee");
        const TimePoint begun = rig.now();
        (void)rig.robot->stop();
        return seconds(rig.now() - begun);
    };
    // It is asked three times, for what it does and for its whole state: no more than ten frames.
    EXPECT_LT(time_to_stop(false), time_to_stop(true) + 3 * 10 * 0.5);
}

/// Another program moves it as soon as it stands, and somebody sees that.
TEST(Stop, OneThatIsAskedForWhileAnotherIsCheckedIsCarriedOut)
{
    LossyRobot one("version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\nid = 1\nmodel = \"MG\"\n"
                   "profile = \"rmd-2.35\"\n");
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 1s)), "");
    std::optional<wire::Frame> turn;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        if (frame.data[0] == 0xA2 && !turn)
            turn = frame;
        return false;
    };
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.6}, 100ms)), "");
    ASSERT_TRUE(turn);
    bool has_stopped = false, is_moved = false;
    one.losses.others = [&](const wire::Frame& frame) -> std::optional<wire::Frame> {
        const bool is_reading = frame.data[0] == 0x9C;
        has_stopped = has_stopped || !is_reading;
        if (!has_stopped || !is_reading || std::exchange(is_moved, true))
            return std::nullopt;
        one.robot->request_stop();
        return turn;
    };
    const auto knee = one.robot->stop().front();
    ASSERT_TRUE(is_moved);
    EXPECT_EQ(knee.outcome, Stopped::Outcome::confirmed) << to_sentence(knee.why);
    EXPECT_LT(std::abs(one.simulator->world().look("knee")->velocity_rad_s), 0.01);
}

TEST(Stop, ARequestedStopEndsTheLoop)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.robot->set("left_knee", {.mode = Mode::velocity, .velocity_rad_s = units::rad(20)}));
    int calls = 0;
    const auto ran = rig.robot->run(5ms, [&](Robot& robot) {
        if (++calls == 50)
            robot.request_stop();
    });
    ASSERT_FALSE(ran.has_value());
    EXPECT_EQ(ran.error().code, Errc::stopped);
    EXPECT_EQ(calls, 50);
    EXPECT_NEAR(rig.truth_rad_s("left_knee"), 0.0, 1e-3);
}

} // namespace
} // namespace sinew::robot::test
