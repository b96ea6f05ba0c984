#include "tests/robot/blocked_knee.hpp"
#include "tests/robot/by_hand.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>

/// Servos that carry a load while they are stopped: what a servo holds with gives way to it.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// An arm that carries so much, and servos that carry nothing on its bus or on another one.
struct Servos {
    int others = 0;
    int bit_rate = 1'500'000;
    double gravity_torque_nm = 0.0;
    int bit_rate_of_others = 0; ///< they have a bus of their own
};

std::string file_text(const Servos& servos)
{
    const auto bus = [](std::string_view name, int bit_rate) {
        return fmt::format("[bus.{}]\nfamily = \"sam\"\nbit_rate = {}\n", name, bit_rate);
    };
    const auto servo = [](std::string_view name, std::string_view of, int id) {
        return fmt::format("[joint.{}]\nbus = \"{}\"\nid = {}\nmodel = \"SAM-20\"\n", name, of, id);
    };
    std::string text = "version = 1\n" + bus("s", servos.bit_rate);
    if (servos.bit_rate_of_others != 0)
        text += bus("t", servos.bit_rate_of_others);
    text += servo("arm", "s", 1) + fmt::format("[joint.arm.plant]\ngravity_torque_nm = {}\ngravity_zero_deg = -60\n",
                                               servos.gravity_torque_nm);
    for (int id = 2; id < 2 + servos.others; ++id)
        text += servo(fmt::format("j{}", id), servos.bit_rate_of_others != 0 ? "t" : "s", id);
    return text;
}

/// How far the arm goes from where it was, and all of its way, at every frame of its bus.
class Way
{
public:
    explicit Way(Rig& rig) : rig_(rig), from_(rig.truth_rad("arm")), before_(from_)
    {
        rig.robot->buses()[0]->set_tap([this](const bus::Tapped&) { look(); });
    }
    void look()
    {
        const double now = rig_.truth_rad("arm");
        furthest_ = std::max(furthest_, std::abs(now - from_));
        all_ += std::abs(now - std::exchange(before_, now));
    }
    double furthest_deg() const { return units::deg(furthest_); }
    double all_deg() const { return units::deg(all_); }

private:
    Rig& rig_;
    double from_, before_, furthest_ = 0.0, all_ = 0.0;
};

/// How often the arm is braked.
class Brakes
{
public:
    explicit Brakes(Rig& rig) : rig_(rig)
    {
        rig.robot->buses()[0]->set_tap([this](const bus::Tapped&) { look(); });
    }
    void look()
    {
        const bool is_braked = rig_.simulator->world().look("arm")->mode == "brake";
        times_ += is_braked && !was_braked_ ? 1 : 0;
        was_braked_ = is_braked;
    }
    int times() const { return times_; }

private:
    Rig& rig_;
    bool was_braked_ = false;
    int times_ = 0;
};

void cycle(Rig& rig, int times)
{
    for (int i = 0; i < times; ++i) {
        (void)rig.robot->cycle();
        wait(*rig.simulator, 10ms);
    }
}

/// It was told anew where to hold every 0.2 s, and each time gave way a little more.
TEST(Loaded, AnArmDoesNotSinkBecauseItIsToldToStopAgainAndAgain)
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

/// An adapter that was pulled and put back: it may be braked first, for nobody knows where it is.
TEST(Loaded, AnArmWhoseLinkIsBackIsHeldByEveryStopThatFollows)
{
    Rig rig(file_of(file_text({.gravity_torque_nm = 0.5})));
    rig.enable();
    ASSERT_EQ(said(rig.run(1s)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("s", false));
    EXPECT_NE(said(rig.run(1s)), "");
    ASSERT_TRUE(rig.simulator->set_plugged("s", true));
    cycle(rig, 100);
    for (int times = 0; times < 3; ++times) {
        const auto arm = rig.robot->stop().front();
        EXPECT_EQ(arm.outcome, Stopped::Outcome::confirmed) << to_sentence(arm.why);
        EXPECT_EQ(arm.did, Mode::hold);
        EXPECT_EQ(rig.simulator->world().look("arm")->mode, "general");
    }
}

/// An adapter that was pulled and put back, and each stop braked it for a look.
TEST(Loaded, AnArmWhoseLinkIsBackAndThatHoldsDoesNotSinkInTheStopsThatFollow)
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
        cycle(rig, 100);
    }
    EXPECT_LT(way.furthest_deg(), 0.5);
}

/// What turns fast may be told where to hold for a short time only; that is no reason to brake what stands.
TEST(Loaded, AnArmIsHeldByAStopAlthoughAServoBesideItTurnsFast)
{
    for (const double speed_deg_s : {20.0, 40.0, 60.0, 80.0})
        for (int asked_at = 1; asked_at < 60; asked_at += 3) {
            Rig rig(file_of(file_text({.others = 15, .bit_rate = 57'600, .gravity_torque_nm = 1.0})));
            rig.enable();
            ASSERT_EQ(said(rig.run(1s)), "");
            ASSERT_EQ(said(rig.robot->set("j2", {.mode = Mode::position,
                                                 .position_rad = rig.truth_rad("j2") + units::rad(100),
                                                 .velocity_rad_s = units::rad(speed_deg_s)})),
                      "");
            ASSERT_EQ(said(rig.run(300ms)), "");
            ASSERT_GT(std::abs(rig.truth_rad_s("j2")), units::rad(speed_deg_s / 2));
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
