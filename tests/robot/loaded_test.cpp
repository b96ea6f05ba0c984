#include "tests/robot/blocked_knee.hpp"
#include "tests/robot/loaded_arm.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

/// Servos that carry a load while they are stopped: what a servo holds with gives way to it.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Loaded, AnArmOfASlowLineIsHeldByAStopAndDoesNotGoToAndFro)
{
    Rig rig(file_of(file_text({.others = 7, .bit_rate = 9600, .gravity_torque_nm = 1.0})));
    rig.enable();
    ASSERT_EQ(said(rig.run(3s)), "");
    Way way(rig);
    for (const auto& one : rig.robot->stop())
        EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed) << one.joint << ": " << to_sentence(one.why);
    EXPECT_LT(way.furthest_deg(), 1.0);
    EXPECT_LT(way.all_deg(), 1.5);
}

/// Its time-outs make every look long. So is a stop for a silence.
TEST(Loaded, AnArmIsHeldByAStopAlthoughAnotherServoIsDead)
{
    for (const int bit_rate_of_others : {0, 115'200}) {
        Rig rig(file_of(file_text({.others = 7, .gravity_torque_nm = 1.0, .bit_rate_of_others = bit_rate_of_others})));
        rig.enable();
        ASSERT_EQ(said(rig.run(1s)), "");
        rig.inject(sim::FaultKind::power_cut, "j2");
        Way way(rig);
        const auto arm = rig.robot->stop().front();
        EXPECT_EQ(arm.outcome, Stopped::Outcome::confirmed) << to_sentence(arm.why);
        EXPECT_EQ(arm.did, Mode::hold);
        cycle(rig, 300);
        EXPECT_LT(way.furthest_deg(), 1.0) << bit_rate_of_others;
    }
}

TEST(Loaded, AnArmBesideABusThatTakesLongIsDrivenByCycles)
{
    Rig rig(file_of(file_text({.others = 12, .bit_rate = 115'200, .bit_rate_of_others = 9600})));
    rig.enable();
    const double from = rig.truth_rad("arm");
    for (int i = 0; i < 60; ++i) {
        ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::position, .position_rad = from + 0.3})), "");
        ASSERT_EQ(said(rig.robot->cycle()), "");
        wait(*rig.simulator, 10ms);
    }
    EXPECT_NEAR(rig.truth_rad("arm") - from, 0.3, 0.05);
}

TEST(Loaded, AMotorThatHasNotHeardItsStopIsToldItByAnotherOneWhateverTheProgramDoesThen)
{
    for (const bool reads : {true, false}) {
        LossyRobot one("version = 1\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\nid = 1\nmodel = \"MG\"\n"
                       "profile = \"rmd-2.35\"\n");
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 1s)), "");
        one.losses.of_sent = [](const wire::Frame&) { return true; };
        EXPECT_EQ(one.robot->stop().front().outcome, Stopped::Outcome::failed);
        one.losses.of_sent = [](const wire::Frame&) { return false; };
        one.robot->request_stop();
        if (reads) {
            EXPECT_EQ(said(one.robot->read()), "");
        } else {
            EXPECT_EQ(one.robot->enable().error().code, Errc::stopped) << "it refuses once";
        }
        wait(*one.simulator, 100ms);
        EXPECT_LT(std::abs(one.simulator->world().look("knee")->velocity_rad_s), 0.01) << reads;
    }
}

/// It owed the stop before, by a policy that lets its load down.
TEST(Loaded, AnEnableThatSucceedsLeavesNobodyBraked)
{
    Rig rig(file_of(file_text({.others = 15, .bit_rate = 9600}) + "[safety]\npolicy = \"brake\"\n"));
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    rig.inject(sim::FaultKind::unplug, "arm");
    EXPECT_EQ(rig.robot->stop().front().outcome, Stopped::Outcome::failed);
    rig.simulator->world().mend("arm");
    rig.enable();
    EXPECT_EQ(rig.simulator->world().look("arm")->mode, "general");
}

/// What turns fast may be told where to hold for a short time only; that is no reason to brake what stands.
TEST(Loaded, AnArmIsHeldByAStopAlthoughAServoBesideItTurnsFast)
{
    for (const auto& [speed_deg_s, reads_twice] :
         {std::pair{20.0, false}, {40.0, false}, {60.0, false}, {80.0, false}, {60.0, true}, {80.0, true}})
        for (int asked_at = 1; asked_at < 60; asked_at += 7) {
            bus::Settings settings;
            settings.double_read = reads_twice;
            Rig rig(file_of(file_text({.others = 15, .bit_rate = 57'600, .gravity_torque_nm = 1.0})), settings);
            rig.enable();
            ASSERT_EQ(said(rig.run(1s)), "");
            ASSERT_EQ(said(rig.robot->set("j2", {.mode = Mode::position,
                                                 .position_rad = rig.truth_rad("j2") + units::rad(100),
                                                 .velocity_rad_s = units::rad(speed_deg_s)})),
                      "");
            ASSERT_EQ(said(rig.run(300ms)), "");
            ASSERT_GT(std::abs(rig.truth_rad_s("j2")), units::rad(speed_deg_s / 3)); // it is led
            Brakes brakes(rig);
            int sent = 0;
            rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
                brakes.look();
                if (tapped.verdict == bus::Verdict::sent && ++sent == asked_at)
                    rig.robot->request_stop();
            });
            EXPECT_EQ(rig.run(1s).error().code, Errc::stopped);
            cycle(rig, 100);
            EXPECT_EQ(brakes.times(), 0) << speed_deg_s << " deg/s, at frame " << asked_at;
        }
}

/// One was let go of by `enable`, which says nothing of how long it takes to look at all.
TEST(Loaded, AnArmIsHeldByAStopBeforeTheFirstCycleOfASlowLine)
{
    Rig rig(file_of(file_text({.others = 15, .bit_rate = 9600, .gravity_torque_nm = 1.0})));
    rig.enable();
    Brakes brakes(rig);
    const auto arm = rig.robot->stop().front();
    EXPECT_EQ(arm.outcome, Stopped::Outcome::confirmed) << to_sentence(arm.why);
    EXPECT_EQ(brakes.times(), 0);
}

/// The exchange that waits for it takes so long that the others may be braked; they are told where to hold before
/// anybody waits for it once more.
TEST(Loaded, AnArmHardlySinksWhereAnotherServoHasFallenSilent)
{
    for (const int bit_rate : {57'600, 115'200, 1'500'000})
        for (const auto* dead : {"j2", "j9", "j16"}) {
            Rig rig(file_of(file_text({.others = 15, .bit_rate = bit_rate, .gravity_torque_nm = 1.0})));
            rig.enable();
            ASSERT_EQ(said(rig.run(2s)), "");
            rig.inject(sim::FaultKind::unplug, dead);
            Way way(rig);
            EXPECT_EQ(rig.run(5s).error().code, Errc::timeout);
            cycle(rig, 50);
            EXPECT_LT(way.furthest_deg(), 6.0) << dead << " at " << bit_rate << " bps"; // it was 22
            EXPECT_EQ(rig.simulator->world().look("arm")->mode, "general");
        }
}

/// The stop ends what the others were asked, and they are not silent because of that.
TEST(Loaded, AnArmHardlySinksInAStopThatIsAskedForWhileAnotherServoIsSilent)
{
    for (const int bit_rate : {115'200, 1'500'000})
        for (int asked_at = 1; asked_at < 70; asked_at += 6) {
            Rig rig(file_of(file_text({.others = 15, .bit_rate = bit_rate, .gravity_torque_nm = 1.0})));
            rig.enable();
            ASSERT_EQ(said(rig.run(2s)), "");
            rig.inject(sim::FaultKind::unplug, "j16");
            Way way(rig);
            int sent = 0;
            rig.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
                way.look();
                if (tapped.verdict == bus::Verdict::sent && ++sent == asked_at)
                    rig.robot->request_stop();
            });
            EXPECT_FALSE(rig.run(5s).has_value());
            cycle(rig, 50);
            EXPECT_LT(way.furthest_deg(), 6.0) << "at frame " << asked_at << ", " << bit_rate << " bps"; // it was 23
        }
}

/// What is looked at seldom has not been moved because of that.
TEST(Loaded, AnArmOfABusWithALowRateIsNotBrakedByAStop)
{
    Rig rig(file_of(file_text({.gravity_torque_nm = 1.0, .rate_hz = 5})));
    rig.enable();
    ASSERT_EQ(said(rig.run(3s)), "");
    Brakes brakes(rig);
    rig.robot->request_stop();
    EXPECT_EQ(rig.run(1s).error().code, Errc::stopped);
    EXPECT_EQ(brakes.times(), 0);
}

/// Each was braked, for the program had looked at nobody for a while.
TEST(Loaded, AnArmOfASlowLineIsBrakedOnceAtMostByAStopAfterAPause)
{
    Rig rig(file_of(file_text({.others = 15, .bit_rate = 9600, .gravity_torque_nm = 1.0})));
    rig.enable();
    ASSERT_EQ(said(rig.run(3s)), "");
    wait(*rig.simulator, 1s);
    Brakes brakes(rig);
    for (const auto& one : rig.robot->stop())
        EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed) << one.joint << ": " << to_sentence(one.why);
    EXPECT_LE(brakes.times(), 1);
    EXPECT_EQ(rig.simulator->world().look("arm")->mode, "general");
}

/// Each letting go lets the load down, and none is acknowledged.
TEST(Loaded, AMotorThatOwesItsStopIsLetGoOfThreeTimesAtMost)
{
    LossyRobot one(blocked_knee);
    ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 3s)), "");
    one.losses.of_sent = [](const wire::Frame&) { return true; };
    EXPECT_NE(said(one.robot->wait(2s, 10ms)), "");
    int lettings_go = 0;
    one.losses.of_sent = [&](const wire::Frame& frame) {
        lettings_go += frame.data[0] == 0xA1 ? 1 : 0;
        return false;
    };
    one.losses.of_heard = [](const wire::Frame& frame) { return frame.data[0] == 0xA1; };
    for (int i = 0; i < 500; ++i) {
        (void)one.robot->cycle();
        wait(*one.simulator, 10ms);
    }
    EXPECT_EQ(lettings_go, 3);
}

} // namespace
} // namespace sinew::robot::test
