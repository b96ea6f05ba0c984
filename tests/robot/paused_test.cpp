#include "tests/robot/blocked_knee.hpp"
#include "tests/robot/by_hand.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <optional>
#include <utility>
#include <vector>

/// A program that stood still, whoever kept it, and a robot that was stopped long ago: no place of before is told.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

constexpr double hardly_deg = 2.0;

/// Its exchange lasts longer than a turn of the loop, and the arm is the last to be asked.
std::string arm_among_others(std::string_view more = {})
{
    std::string text = "version = 1\n[safety]\nsilence_max_s = 5\n[bus.s]\nfamily = \"sam\"\nbit_rate = 57600\n";
    for (int id = 2; id < 8; ++id)
        text += fmt::format("[joint.j{0}]\nbus = \"s\"\nid = {0}\nmodel = \"SAM-20\"\n", id);
    return text + fmt::format("[joint.arm]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n{}\n", more);
}

/// How far an arm goes from where it was guided, while its robot is driven.
struct Leap {
    explicit Leap(Rig& rig) : rig_(rig), guided_rad_(rig.truth_rad("arm")) {}
    void look() { furthest_rad_ = std::max(furthest_rad_, std::abs(rig_.truth_rad("arm") - guided_rad_)); }
    double furthest_deg() const { return units::deg(furthest_rad_); }

private:
    Rig& rig_;
    double guided_rad_, furthest_rad_ = 0.0;
};

/// A callback that waits for its user and then does something, while the line is busy. How far the arm leaps in the
/// second after it.
double leap_deg(int turns_before, std::string_view more, const std::function<void(Robot&, double before_rad)>& then)
{
    Rig rig(file_of(arm_among_others(more)));
    rig.enable();
    EXPECT_EQ(said(rig.robot->set("arm", {.mode = Mode::brake})), "");
    EXPECT_EQ(said(rig.run(500ms)), "");
    std::optional<Leap> leap;
    int turns = 0;
    (void)rig.robot->run(
        5ms,
        [&](Robot& robot) {
            if (leap)
                return leap->look();
            if (++turns < turns_before)
                return;
            const double before_rad = rig.truth_rad("arm");
            guide_by_hand(*rig.simulator, 400ms, 0.5);
            leap.emplace(rig);
            EXPECT_GT(std::abs(rig.truth_rad("arm") - before_rad), units::rad(20));
            then(robot, before_rad);
        },
        rig.now() + 1s);
    for (int i = 0; i < 20; ++i, leap->look())
        wait(*rig.simulator, 10ms);
    return leap->furthest_deg();
}

TEST(Paused, WhatACallbackSaysAfterItWaitedBeginsWhereTheArmIsNow)
{
    constexpr std::string_view slow = "velocity_max_deg_s = 20";
    constexpr double way_of_a_turn_deg = 20.0 * 0.6; // in what is left of the second, with half as much for its ramp
    for (int turns = 10; turns < 18; ++turns) {      // wherever the exchange is
        EXPECT_LT(leap_deg(turns, {},
                           [](Robot& robot, double) { EXPECT_EQ(said(robot.set("arm", {.mode = Mode::hold})), ""); }),
                  hardly_deg)
            << turns;
        EXPECT_LT(leap_deg(turns, {}, [](Robot& robot, double) { (void)robot.stop(); }), hardly_deg) << turns;
        EXPECT_LT(leap_deg(turns, slow,
                           [](Robot& robot, double before_rad) {
                               EXPECT_EQ(said(robot.set("arm", {.mode = Mode::position,
                                                                .position_rad = before_rad,
                                                                .velocity_rad_s = units::rad(20)})),
                                         "");
                           }),
                  way_of_a_turn_deg)
            << turns;
        EXPECT_LT(leap_deg(turns, slow,
                           [](Robot& robot, double before_rad) {
                               EXPECT_EQ(said(robot.set("arm", {.mode = Mode::position, .position_rad = before_rad})),
                                         "");
                           }),
                  way_of_a_turn_deg)
            << turns;
    }
}

/// The arm was braked and guided by hand while its program waited.
class GuidedBefore : public testing::Test
{
protected:
    void SetUp() override
    {
        rig_.enable();
        ASSERT_EQ(said(rig_.robot->set("arm", {.mode = Mode::brake})), "");
        ASSERT_EQ(said(rig_.run(200ms)), "");
        guide_by_hand(*rig_.simulator, 400ms, 0.5);
        leap_.emplace(rig_);
    }

    Rig rig_{file_of(arm_among_others())};
    std::optional<Leap> leap_;
};

TEST_F(GuidedBefore, AHoldThatWasSetBeforeAReadingHoldsWhereThatFoundTheArm)
{
    ASSERT_EQ(said(rig_.robot->set("arm", {.mode = Mode::hold})), "");
    ASSERT_EQ(said(rig_.robot->read()), "");
    for (int i = 0; i < 100; ++i, leap_->look())
        ASSERT_EQ(said(rig_.run(10ms)), "");
    EXPECT_LT(leap_->furthest_deg(), hardly_deg);
}

TEST_F(GuidedBefore, AStopDuringTheFirstLookAfterAPauseTellsNoPlaceOfBefore)
{
    int asked = 0;
    rig_.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
        leap_->look();
        if (tapped.verdict == bus::Verdict::sent && ++asked == 3)
            rig_.robot->request_stop();
    });
    EXPECT_EQ(rig_.robot->cycle().error().code, Errc::stopped);
    leap_->look();
    EXPECT_LT(leap_->furthest_deg(), hardly_deg);
}

/// A link that says when it was read, as those of the system do, and not when the answer came.
class LateReader final : public link::ByteLink
{
public:
    LateReader(std::unique_ptr<link::ByteLink> link, link::Clock& clock, std::function<void()>& before_reading)
        : link_(std::move(link)), clock_(clock), before_reading_(before_reading)
    {
    }
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        return link_->write(bytes);
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        before_reading_();
        auto arrival = link_->read(into);
        if (arrival)
            arrival->at = clock_.now();
        return arrival;
    }
    int handle() const override { return link_->handle(); }
    link::LinkState state() const override { return link_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return link_->set_bit_rate(rate); }

private:
    std::unique_ptr<link::ByteLink> link_;
    link::Clock& clock_;
    std::function<void()>& before_reading_;
};

/// SIGSTOP, a debugger, a machine that stood still.
TEST(Paused, AnAnswerThatLayUnreadForThreeSecondsIsNoNewOne)
{
    const auto file = file_of(servo_by_hand);
    auto simulator = *sim::Simulator::make(file);
    std::function<void()> before_reading = [] {};
    link::Links links;
    links.add({.name = "sim",
               .form = "sim:FILE#BUS",
               .says = "A bus of this test.",
               .options = {},
               .open = [&](const link::Uri& uri, link::Clock&) -> std::expected<link::AnyLink, Error> {
                   auto link = simulator->open(uri.fragment);
                   if (!link)
                       return link;
                   return std::make_unique<LateReader>(std::move(std::get<std::unique_ptr<link::ByteLink>>(*link)),
                                                       simulator->clock(), before_reading);
               }});
    auto robot = Robot::open(file, links, simulator->clock(), {.simulated = true});
    ASSERT_TRUE(robot);
    ASSERT_EQ(said(robot->enable()), "");
    ASSERT_EQ(said(robot->set("arm", {.mode = Mode::brake})), "");
    ASSERT_EQ(said(robot->wait(200ms)), "");
    constexpr std::uint8_t ask_for_state = 0xAD;
    bool is_out = false, has_paused = false;
    robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
        is_out = tapped.verdict == bus::Verdict::sent && tapped.bytes[2] == ask_for_state;
    });
    before_reading = [&] {
        if (!is_out || std::exchange(has_paused, true))
            return;
        wait(*simulator, 10ms); // it answers
        guide_by_hand(*simulator, 3s, 0.2);
    };
    const auto cycled = robot->cycle();
    ASSERT_TRUE(has_paused);
    EXPECT_NE(said(cycled).find("has not answered for 3.0"), std::string::npos) << said(cycled);
    const double guided_rad = simulator->world().look("arm")->position_rad;
    double furthest_rad = 0.0;
    for (int i = 0; i < 100; ++i) {
        (void)robot->cycle();
        wait(*simulator, 10ms);
        furthest_rad = std::max(furthest_rad, std::abs(simulator->world().look("arm")->position_rad - guided_rad));
    }
    EXPECT_LT(units::deg(furthest_rad), hardly_deg);
}

TEST(Paused, ARobotThatWasEnabledLongBeforeItsFirstCycleIsStoppedForTheProgramThatStoodStill)
{
    for (const bool runs : {false, true}) {
        Rig rig(file_of(servo_by_hand));
        rig.enable();
        wait(*rig.simulator, 3s);
        EXPECT_NE(said(runs ? rig.run(100ms) : rig.robot->cycle()).find("this program itself stood still for 3.0"),
                  std::string::npos)
            << runs;
    }
    Rig rig(file_of(servo_by_hand));
    rig.enable();
    ASSERT_EQ(said(rig.run(100ms)), "");
    wait(*rig.simulator, 2s);
    EXPECT_NE(said(rig.run(100ms)).find("this program itself stood still for 2.0"), std::string::npos)
        << "between two calls";
}

/// An emergency switch cuts the supply of a stopped robot, and somebody moves the arm.
class StoppedBefore : public testing::Test
{
protected:
    static constexpr auto two_buses =
        "version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\nmodel = \"SAM-20\"\n"
        "[bus.t]\nfamily = \"sam\"\n[joint.other]\nbus = \"t\"\nid = 1\nmodel = \"SAM-20\"\n";

    StoppedBefore() : rig_(file_of(two_buses))
    {
        rig_.enable();
        EXPECT_EQ(said(rig_.run(200ms)), "");
        for (const auto& one : rig_.robot->stop())
            EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed);
        cycle(20);
    }
    void cycle(int times)
    {
        for (int i = 0; i < times; ++i) {
            (void)rig_.robot->cycle();
            wait(*rig_.simulator, 10ms);
        }
    }
    void switch_off_and_guide()
    {
        rig_.inject(sim::FaultKind::power_cut, "arm", 1.0);
        sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.2};
        push.torque_nm = 0.2;
        rig_.simulator->world().inject(push);
        cycle(200);
        ASSERT_GT(units::deg(std::abs(rig_.truth_rad("arm"))), 20.0);
        leap_.emplace(rig_);
    }
    double furthest_deg_after(const std::function<void()>& what)
    {
        switch_off_and_guide();
        what();
        for (int i = 0; i < 100; ++i, leap_->look())
            cycle(1);
        return leap_->furthest_deg();
    }
    void plug(bool is_in)
    {
        for (const auto* bus : {"t", "s"})
            ASSERT_TRUE(rig_.simulator->set_plugged(bus, is_in));
    }

    Rig rig_;
    std::optional<Leap> leap_;
};

TEST_F(StoppedBefore, AnotherStopTellsTheArmNoPlace)
{
    EXPECT_LT(furthest_deg_after([&] { rig_.robot->request_stop(); }), hardly_deg);
}

TEST_F(StoppedBefore, AnotherStopBeforeAReadingTellsTheArmNoPlace)
{
    const auto stop_and_read = [&] {
        rig_.robot->request_stop();
        (void)rig_.robot->read();
    };
    EXPECT_LT(furthest_deg_after(stop_and_read), hardly_deg);
}

TEST_F(StoppedBefore, TheLinkOfAnotherBusThatIsLostTellsTheArmNoPlace)
{
    EXPECT_LT(furthest_deg_after([&] { EXPECT_TRUE(rig_.simulator->set_plugged("t", false)); }), hardly_deg);
}

TEST_F(StoppedBefore, LinksThatWereLostAndAreBackTellTheArmNoPlace)
{
    plug(false);
    EXPECT_LT(furthest_deg_after([&] { plug(true); }), hardly_deg);
}

TEST_F(StoppedBefore, AStopThatTheProgramCallsHoldsTheArmWhereItIs)
{
    const auto stop_twice = [&] {
        rig_.robot->request_stop();
        (void)rig_.robot->stop();
    };
    EXPECT_LT(furthest_deg_after(stop_twice), hardly_deg);
    EXPECT_EQ(rig_.simulator->world().look("arm")->mode, "general") << "and not limp";
}

/// Nearer than its load could have brought it, while nobody asked.
TEST_F(StoppedBefore, AnArmThatWasMovedALittleWhileItsProgramWaitedIsHeldWhereItIs)
{
    for (const bool enables : {false, true}) {
        rig_.enable();
        ASSERT_EQ(said(rig_.run(200ms)), "");
        (void)rig_.robot->stop();
        const double before_rad = rig_.truth_rad("arm");
        rig_.inject(sim::FaultKind::power_cut, "arm", 1.0);
        sim::Fault push{.kind = sim::FaultKind::push, .joint = "arm", .for_s = 0.1};
        push.torque_nm = 0.15;
        rig_.simulator->world().inject(push);
        wait(*rig_.simulator, 3s);
        const double moved_deg = units::deg(std::abs(rig_.truth_rad("arm") - before_rad));
        ASSERT_TRUE(moved_deg > 3.0 && moved_deg < 9.0) << moved_deg;
        Leap leap(rig_);
        rig_.robot->buses()[0]->set_tap([&](const bus::Tapped& tapped) {
            constexpr std::uint8_t position_control = 0xC8;
            leap.look();
            if (enables && tapped.bytes.size() > 2 && tapped.bytes[2] == position_control)
                rig_.robot->request_stop();
        });
        if (enables) {
            EXPECT_EQ(rig_.robot->enable().error().code, Errc::stopped);
        } else {
            ASSERT_EQ(said(rig_.robot->read()), "");
            (void)rig_.robot->stop();
        }
        rig_.robot->buses()[0]->set_tap({});
        for (int i = 0; i < 50; ++i, leap.look())
            cycle(1);
        EXPECT_LT(leap.furthest_deg(), hardly_deg) << enables;
    }
}

TEST_F(StoppedBefore, AnArmThatHoldsGoesOnHoldingWhateverElseIsAskedToStop)
{
    rig_.robot->request_stop();
    cycle(20);
    EXPECT_EQ(rig_.simulator->world().look("arm")->mode, "general");
    ASSERT_TRUE(rig_.simulator->set_plugged("t", false));
    cycle(20);
    EXPECT_EQ(rig_.simulator->world().look("arm")->mode, "general");
}

TEST(Paused, AServoOfASlowLineThatTurnsIsHeldWhereItIsWhenItIsStopped)
{
    constexpr double speed_deg_s = 100.0, oldest_place_s = 0.1;
    for (const int bit_rate : {57600, 9600})
        for (int ms = 1000; ms < 1200; ms += 50) {
            std::string text = fmt::format(
                "version = 1\n[safety]\nsilence_max_s = 5\n[bus.s]\nfamily = \"sam\"\nbit_rate = {}\nrate_hz = 5\n",
                bit_rate);
            for (int id = 0; id < 16; ++id)
                text += fmt::format(
                    "[joint.j{0}]\nbus = \"s\"\nid = {0}\nmodel = \"SAM-20\"\nvelocity_max_deg_s = 120\n", id);
            Rig rig(file_of(text));
            rig.enable();
            ASSERT_EQ(said(rig.run(1s)), "");
            for (Joint& joint : rig.robot->joints())
                ASSERT_EQ(said(joint.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(speed_deg_s)})), "");
            ASSERT_EQ(said(rig.run(ms * 1ms)), "");
            std::vector<double> stopped_at;
            for (Joint& joint : rig.robot->joints())
                stopped_at.push_back(rig.truth_rad(joint));
            for (const auto& one : rig.robot->stop()) {
                EXPECT_EQ(one.outcome, Stopped::Outcome::confirmed) << one.joint;
                EXPECT_EQ(one.did, Mode::hold) << one.joint;
            }
            for (std::size_t i = 0; i < stopped_at.size(); ++i)
                EXPECT_LT(units::deg(stopped_at[i] - rig.truth_rad(rig.robot->joints()[i])),
                          speed_deg_s * oldest_place_s)
                    << bit_rate << " bps, joint " << i;
        }
}

/// It presses on what blocks it when its link is lost, and goes on to press when it is told to hold.
TEST(Paused, AMotorThatPressedWhenItsLinkWasLostIsLetGoOfOnceItsOwedStopIsHeard)
{
    for (const bool loses_adapter : {false, true}) {
        LossyRobot one(blocked_knee);
        ASSERT_EQ(said(one.run({.mode = Mode::velocity, .velocity_rad_s = 0.5}, 3s)), "");
        const auto current_a = [&] { return std::abs(one.simulator->world().look("knee")->current_a); };
        const double pressing_a = current_a();
        if (loses_adapter) {
            ASSERT_TRUE(one.simulator->set_plugged("r", false));
        }
        one.losses.of_sent = [](const wire::Frame&) { return true; };
        EXPECT_NE(said(one.robot->wait(2s, 10ms)), "");
        int commands = 0;
        one.losses.of_sent = [&](const wire::Frame& frame) {
            commands += frame.data[0] == 0xA1 || frame.data[0] == 0xA2 ? 1 : 0;
            return false;
        };
        if (loses_adapter) {
            ASSERT_TRUE(one.simulator->set_plugged("r", true));
        }
        const auto cycle = [&] {
            for (int i = 0; i < 300; ++i) {
                (void)one.robot->cycle();
                wait(*one.simulator, 10ms);
            }
        };
        cycle();
        EXPECT_LT(current_a(), pressing_a / 2) << loses_adapter;
        commands = 0;
        cycle();
        EXPECT_EQ(commands, 0) << "it was heard, and is left alone";
    }
}

} // namespace
} // namespace sinew::robot::test
