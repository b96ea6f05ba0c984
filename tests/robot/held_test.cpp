#include "sinew/robot/core.hpp"
#include "sinew/robot/load.hpp"
#include "tests/robot/loaded_arm.hpp"

#include <gtest/gtest.h>
#include <vector>

/// Servos that hold since their robot was stopped, and what a program, a guardian or another stop says to them then.
namespace sinew::robot::test {
namespace {

/// It was told anew where to hold every 0.2 s, and each time gave way a little more.
TEST(Held, AnArmDoesNotSinkBecauseItIsToldToStopAgainAndAgain)
{
    for (const int bit_rate : {1'500'000, 115'200})
        for (const double load_nm : {0.5, 0.7, 1.0}) {
            Rig rig(file_of(file_text({.bit_rate = bit_rate, .gravity_torque_nm = load_nm})));
            rig.enable();
            ASSERT_EQ(said(rig.run(3s)), "");
            Way way(rig);
            for (int times = 0; times < 3; ++times) {
                for (const auto& one : rig.robot->stop())
                    EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed) << to_sentence(one.why);
                cycle(rig, 300);
            }
            EXPECT_LT(way.furthest_deg(), 1.0) << load_nm << " Nm at " << bit_rate << " bps";
        }
}

/// An adapter that was pulled and put back: the first stop may brake it, for nobody knows where it is. Later ones need
/// not, and none leaves it so.
TEST(Held, AnArmWhoseLinkIsBackIsHeldByEveryStopAndDoesNotSinkInThem)
{
    Rig rig(file_of(file_text({.gravity_torque_nm = 1.0})));
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("s", false));
    EXPECT_NE(said(rig.run(1s)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("s", true));
    cycle(rig, 100);
    (void)rig.robot->stop();
    Way way(rig);
    for (int times = 0; times < 3; ++times) {
        const auto arm = rig.robot->stop().front();
        EXPECT_EQ(arm.outcome, Stopped::Outcome::confirmed) << to_sentence(arm.why);
        EXPECT_EQ(arm.did, Mode::hold);
        EXPECT_EQ(rig.simulator->world().look("arm")->mode, "general");
        cycle(rig, 100);
    }
    EXPECT_LT(way.furthest_deg(), 0.5);
}

/// A program that looks seldom, such as one with a screen.
void poll(Rig& rig, Duration time, Duration period)
{
    for (const TimePoint until = rig.now() + time; rig.now() < until; wait(*rig.simulator, period))
        (void)rig.robot->read();
}

TEST(Held, AnArmDoesNotSinkInStopsBetweenWhichItIsLookedAtSeldom)
{
    for (const Duration period : {Duration(20ms), Duration(150ms), Duration(500ms)}) {
        Rig rig(file_of(file_text({.gravity_torque_nm = 1.0})));
        rig.enable();
        ASSERT_EQ(said(rig.run(3s)), "");
        (void)rig.robot->stop();
        poll(rig, 2s, period);
        Way way(rig);
        for (int times = 0; times < 5; ++times) {
            const auto arm = rig.robot->stop().front();
            EXPECT_EQ(arm.outcome, Stopped::Outcome::confirmed) << to_sentence(arm.why);
            poll(rig, 2s, period);
        }
        EXPECT_LT(way.furthest_deg(), 2.0) << seconds(period) << " s"; // a new place once; it was one for every stop
    }
}

/// A program that waits for its user, on a machine that has been on for a while. The emergency switch, a hand, and the
/// supply again.
TEST(Held, AnArmThatWasGuidedWhileNobodyLookedIsNotLedBackByAnotherStopHoweverOftenThatHappens)
{
    for (const Duration up : {Duration(0s), Duration(1h)})
        for (const Duration pause : {Duration(2s), Duration(10s), Duration(30s)}) {
            Rig rig(file_of(file_text({})));
            wait(*rig.simulator, up);
            rig.enable();
            ASSERT_EQ(said(rig.run(1s)), "");
            for (int times = 0; times < 3; ++times) {
                (void)rig.robot->stop();
                rig.inject(sim::FaultKind::power_cut, "arm", 1.0);
                guide_by_hand(*rig.simulator, 400ms, 0.2);
                wait(*rig.simulator, pause);
                const double guided = rig.truth_rad("arm");
                Way way(rig);
                (void)rig.robot->stop();
                wait(*rig.simulator, 500ms);
                way.look();
                EXPECT_LT(way.furthest_deg(), 2.0) << seconds(pause) << " s, up for " << seconds(up) << " s";
                EXPECT_NEAR(rig.truth_rad("arm"), guided, units::rad(2));
            }
        }
}

/// A program that looks at a button again and again, which also cuts the supply.
TEST(Held, AnArmThatWasGuidedWithoutItsSupplyIsNotLedBackByStopsThatEndEveryQuestion)
{
    for (const Duration again : {Duration(5ms), Duration(20ms), Duration(33ms), Duration(60ms)}) {
        Rig rig(file_of(file_text({})));
        rig.enable();
        ASSERT_EQ(said(rig.run(1s)), "");
        const TimePoint begun = rig.now();
        TimePoint next = begun;
        double guided = 0.0, furthest = 0.0;
        bool is_cut = false;
        rig.robot->buses()[0]->set_tap([&](const bus::Tapped&) {
            const Duration time = rig.now() - begun;
            if (time > 50ms && !std::exchange(is_cut, true)) {
                rig.inject(sim::FaultKind::power_cut, "arm", 1.0);
                sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.3};
                push.torque_nm = 0.2;
                rig.simulator->world().inject(push);
            }
            if (time < 900ms)
                guided = rig.truth_rad("arm");
            else if (time < 2s)
                furthest = std::max(furthest, std::abs(rig.truth_rad("arm") - guided));
            if (time < 2s && rig.now() >= next) {
                next = rig.now() + again;
                rig.robot->request_stop();
            }
        });
        (void)rig.robot->stop();
        cycle(rig, 50);
        ASSERT_GT(std::abs(guided), units::rad(15)) << seconds(again) << " s";
        EXPECT_LT(units::deg(furthest), 5.0) << seconds(again) << " s"; // it was 83
    }
}

/// At 60 deg/s, since a moment before the stop.
TEST(Held, AServoThatWasSentAwaySinceItWasSeenIsNotLedBackByAStopOfASlowRobot)
{
    for (int ms = 10; ms < 1000; ms += 30) {
        Rig rig(file_of(file_text({.rate_hz = 2})));
        rig.enable();
        ASSERT_EQ(said(rig.run(3s)), "");
        ASSERT_EQ(said(rig.robot->set("arm", {.mode = Mode::velocity, .velocity_rad_s = units::rad(60)})), "");
        ASSERT_EQ(said(rig.run(std::chrono::milliseconds(ms))), "");
        double furthest = rig.truth_rad("arm"), back = 0.0;
        rig.robot->buses()[0]->set_tap([&](const bus::Tapped&) {
            const double now = rig.truth_rad("arm");
            furthest = std::max(furthest, now);
            back = std::max(back, furthest - now);
        });
        (void)rig.robot->stop();
        cycle(rig, 30);
        EXPECT_LT(units::deg(back), 6.0) << ms << " ms";
    }
}

/// A hand kept it from coming to rest, so it owes its stop, and was told a new place after every look.
TEST(Held, AnArmThatOwesItsStopDoesNotSinkWhereItIsLookedAtSeldom)
{
    for (const auto& periods : {std::pair{10ms, 10ms}, {110ms, 110ms}, {250ms, 250ms}, {150ms, 500ms}}) {
        Rig rig(file_of(file_text({.gravity_torque_nm = 1.0})));
        rig.enable();
        ASSERT_EQ(said(rig.run(2s)), "");
        int pushes = 0;
        TimePoint next = rig.now();
        rig.robot->buses()[0]->set_tap([&](const bus::Tapped&) {
            if (rig.now() < next)
                return;
            next = rig.now() + 100ms;
            sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.1};
            push.torque_nm = ++pushes % 2 == 0 ? 0.4 : -0.4;
            rig.simulator->world().inject(push);
        });
        EXPECT_EQ(rig.robot->stop().front().outcome, Stopped::Outcome::failed);
        Way way(rig);
        for (int i = 0; i < 20; ++i) {
            (void)rig.robot->read();
            wait(*rig.simulator, i % 2 == 0 ? periods.first : periods.second);
        }
        EXPECT_LT(way.furthest_deg(), 4.0) << seconds(periods.second) << " s"; // a new place once or twice; it was 36
        EXPECT_FALSE(rig.robot->find("arm")->owes_stop());
    }
}

/// What a guardian would say a minute later, to an arm that lost its supply and was guided meanwhile.
TEST(Held, AGuardianSaysNothingToWhoHoldsWhereAnotherServoOwesItsStop)
{
    const auto file = file_of(file_text({.others = 1}));
    auto simulator = *sim::Simulator::make(file);
    auto core = *Core::make(file, links_of(*simulator), simulator->clock(), {.simulated = true});
    ASSERT_EQ(said(core->enable()), "");
    ASSERT_EQ(said(core->cycle()), "");
    simulator->world().inject({.kind = sim::FaultKind::unplug, .joint = "j2"});
    (void)core->stop("");
    (void)core->read(Depth::motion);
    const auto told = core->lines[0]->blind_stop(Line::Whom::owing, simulator->clock().now());
    for (const auto& requests : {told.seen, told.unseen}) {
        EXPECT_FALSE(requests.empty());
        for (const auto& request : requests)
            EXPECT_EQ(request.id, 2);
    }
}

/// Nothing owes anything.
TEST(Held, AGuardianSaysNothingToARobotThatHasStopped)
{
    const auto file = file_of(file_text({.others = 1}));
    auto simulator = *sim::Simulator::make(file);
    auto core = *Core::make(file, links_of(*simulator), simulator->clock(), {.simulated = true});
    ASSERT_EQ(said(core->enable()), "");
    (void)core->stop("");
    const auto told = core->lines[0]->blind_stop(Line::Whom::owing, simulator->clock().now());
    EXPECT_TRUE(told.seen.empty());
    EXPECT_TRUE(told.unseen.empty());
}

/// There is no bus then.
TEST(Held, WhatAStopOfServosTakesIsPredictedWithoutThem)
{
    const auto load = load_of(file_of(file_text({.others = 1})), "s", {.can = false, .bit_rate = 1'500'000});
    ASSERT_TRUE(load);
    EXPECT_FALSE(load->stop.empty());
}

} // namespace
} // namespace sinew::robot::test
