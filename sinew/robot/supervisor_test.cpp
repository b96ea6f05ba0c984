#include "sinew/base/units.hpp"
#include "sinew/robot/mounting.hpp"
#include "sinew/robot/supervisor.hpp"

#include <gtest/gtest.h>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;
using actuator::Command;
using actuator::Mode;
using actuator::State;
using units::rad;

constexpr TimePoint start{1s};

State at(double deg, TimePoint when, double deg_s = 0.0)
{
    State state;
    state.position_rad = {rad(deg), when};
    state.velocity_rad_s = {rad(deg_s), when};
    return state;
}

Supervisor guard(bool limits_velocity, std::optional<double> step_deg = {})
{
    Rules rules{.limits = {.position_low_rad = rad(-10),
                           .position_high_rad = rad(90),
                           .velocity_max_rad_s = rad(100),
                           .temperature_max_c = 60.0},
                .command_timeout = 200ms,
                .silence_max = 500ms,
                .stop_time = 100ms};
    if (step_deg)
        rules.limits.step_max_rad = rad(*step_deg);
    return {"elbow", 3, rules, limits_velocity};
}

Command position(double deg)
{
    return {.mode = Mode::position, .position_rad = rad(deg)};
}

TEST(Supervisor, TheFirstCommandIsCountedFromTheMeasuredPosition)
{
    Supervisor elbow = guard(false);
    elbow.begin(at(40, start), start);
    EXPECT_FALSE(elbow.admit(position(0), at(40, start), start + 10ms));
    EXPECT_TRUE(elbow.admit(position(41), at(40, start), start + 10ms));
    EXPECT_FALSE(elbow.admit(position(41.1), at(40, start), start + 10ms));
}

TEST(Supervisor, NoPauseMakesALongStepShort)
{
    Supervisor elbow = guard(false);
    elbow.begin(at(0, start), start);
    EXPECT_TRUE(elbow.admit(position(5), at(0, start), start + 10s)) << "50 ms of 100 deg/s";
    EXPECT_FALSE(elbow.admit(position(5.1), at(0, start), start + 10s));
}

TEST(Supervisor, WhatAStepLeavesIsNotSavedForALongerOne)
{
    Supervisor elbow = guard(false);
    elbow.begin(at(0, start), start);
    double here = 0.0;
    for (int i = 1; i <= 20; ++i) {
        const TimePoint now = start + i * 10ms;
        here += 0.2;
        ASSERT_TRUE(elbow.admit(position(here), at(here, now), now));
        elbow.sent(rad(here), now);
    }
    const TimePoint now = start + 210ms;
    EXPECT_TRUE(elbow.admit(position(here + 1.5), at(here, now), now)) << "10 ms, and 5 ms for the unrest of a loop";
    EXPECT_FALSE(elbow.admit(position(here + 1.6), at(here, now), now));
}

TEST(Supervisor, AJointThatTurnedOrWasFreeSavesNothingForALongStepAfterAShortOne)
{
    Supervisor elbow = guard(false);
    elbow.begin(at(0, start), start);
    TimePoint now = start;
    for (int i = 0; i < 20; ++i)
        elbow.follow(rad(0), now += 5ms); // so slow that it seems to stand
    elbow.sent(rad(0), now += 5ms);       // a walk begins
    now += 5ms;
    EXPECT_TRUE(elbow.admit(position(1.0), at(0, now), now)) << "5 ms, and 5 ms for the unrest of a loop";
    EXPECT_FALSE(elbow.admit(position(1.1), at(0, now), now)) << "a leap that nobody was told of before";
}

TEST(Supervisor, FromBeyondALimitAPositionMayLeadBackAndNoFurtherOut)
{
    for (const bool limits_velocity : {false, true}) {
        Supervisor elbow = guard(limits_velocity);
        elbow.begin(at(-12, start), start);
        const auto fine = [&](double deg) {
            return elbow.admit(position(deg), at(-12, start), start + 50ms).has_value();
        };
        EXPECT_TRUE(fine(-12)) << "stay";
        EXPECT_TRUE(fine(-11.5)) << "a part of the way";
        EXPECT_TRUE(fine(-9.5));
        EXPECT_FALSE(fine(-12.1)) << "further out";
        elbow.sent(rad(-11.5), start + 50ms);
        EXPECT_FALSE(elbow.admit(position(-11.6), at(-12, start), start + 100ms)) << "and never back out again";
        elbow.sent(rad(-9.5), start + 100ms);
        EXPECT_FALSE(elbow.admit(position(-10.1), at(-9.5, start), start + 150ms));
    }
}

TEST(Supervisor, AJointThatTurnsBackFromBeyondALimitIsNotSentBackToWhereItWasACycleAgo)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(-15, start), start);
    elbow.follow(rad(-15), start);
    const State now = at(-14, start + 5ms, 200);
    EXPECT_FALSE(elbow.admit(position(-14.5), now, start + 5ms));
    EXPECT_TRUE(elbow.admit(position(-13.5), now, start + 5ms));
}

TEST(Supervisor, AMoveThatNamesNoVelocityGetsTheGreatestWhereTheDeviceKeepsToIt)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(0, start), start);
    const auto move = elbow.admit(position(80), at(0, start), start);
    ASSERT_TRUE(move);
    EXPECT_EQ(move->velocity_rad_s, rad(100));
}

TEST(Supervisor, TheLargestStepHoldsForDevicesThatLimitTheirVelocityToo)
{
    Supervisor elbow = guard(true, 10.0);
    elbow.begin(at(0, start), start);
    EXPECT_TRUE(elbow.admit(position(10), at(0, start), start));
    const auto far = elbow.admit(position(11), at(0, start), start);
    ASSERT_FALSE(far);
    EXPECT_EQ(far.error().detail, "elbow: a step of 11.00 deg from 0.00 deg is more than the 10.00 deg allowed; send "
                                  "smaller steps, or name a velocity");
    Command slow = position(60);
    slow.velocity_rad_s = rad(50);
    EXPECT_TRUE(elbow.admit(slow, at(0, start), start));
}

TEST(Supervisor, WhoStandsBeyondALimitMayComeBackAndNotGoFurther)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(120, start), start);
    const Command hold{.mode = Mode::hold};
    EXPECT_EQ(elbow.judge(at(120, start), hold, start, start, 10ms, start).measure, Measure::none);
    EXPECT_FALSE(elbow.admit({.mode = Mode::velocity, .velocity_rad_s = rad(10)}, at(120, start), start));
    EXPECT_TRUE(elbow.admit({.mode = Mode::velocity, .velocity_rad_s = rad(-10)}, at(120, start), start));
    TimePoint now = start;
    for (int deg = 119; deg >= 95; --deg) {
        now += 100ms;
        elbow.observe(at(deg, now, -10));
        EXPECT_EQ(elbow.judge(at(deg, now), hold, now, now, 10ms, now).measure, Measure::none) << deg;
    }
    for (int i = 0; i < 20; ++i) {
        now += 100ms;
        elbow.observe(at(95, now));
    }
    elbow.observe(at(99, now + 100ms));
    EXPECT_EQ(elbow.judge(at(110, now + 100ms), hold, now, now + 100ms, 10ms, now + 100ms).measure, Measure::stop);
}

TEST(Supervisor, ACommandWithoutEndEndsWhereItCanStillStop)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(80, start), start);
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = rad(60)};
    const auto at_80 = at(80, start + 10ms, 60);
    elbow.observe(at_80);
    // 60 deg/s: 3 deg while it stops and 0.6 deg until the next look.
    EXPECT_EQ(elbow.judge(at_80, turn, start, start, 10ms, start + 10ms).measure, Measure::none);
    const auto near = at(86.5, start + 120ms, 60);
    elbow.observe(near);
    EXPECT_EQ(elbow.judge(near, turn, start, start + 120ms, 10ms, start + 120ms).measure, Measure::end);
}

/// Led on at 100 deg/s, looked at every 10 ms; it may be 17 deg ahead.
Supervisor led(bool limits_velocity = false)
{
    Rules rules{.limits = {.velocity_max_rad_s = rad(100)}, .silence_max = 10s, .lead_max_rad = rad(17)};
    return {"elbow", 3, rules, limits_velocity};
}

TEST(Supervisor, WhatDoesNotFollowIsNotLedOn)
{
    Supervisor elbow = led();
    elbow.begin(at(0, start), start);
    TimePoint now = start;
    double sent = 0.0;
    for (int i = 0; i < 100; ++i) {
        now += 10ms;
        elbow.observe(at(0, now));
        sent = units::deg(elbow.nearest_step_rad(rad(sent + 0.9), now));
        elbow.sent(rad(sent), now);
    }
    EXPECT_NEAR(sent, 17.0, 1e-6);
    const auto further = elbow.admit(position(17.5), at(0, now), now + 10ms);
    ASSERT_FALSE(further);
    EXPECT_NE(further.error().detail.find("stays behind"), std::string::npos) << further.error().detail;
    EXPECT_TRUE(elbow.admit(position(17.0), at(0, now), now + 10ms)) << "it may stay";
    EXPECT_TRUE(elbow.admit(position(16.5), at(0, now), now + 10ms)) << "and come back";
    // It comes free, and is led on when it has nearly come.
    elbow.observe(at(7, now += 10ms));
    EXPECT_FALSE(elbow.admit(position(17.5), at(7, now), now));
    elbow.observe(at(9, now += 10ms));
    EXPECT_TRUE(elbow.admit(position(17.5), at(9, now), now));
}

TEST(Supervisor, AJointThatStaysBehindForASecondHasItsCommandEnded)
{
    for (const bool limits_velocity : {false, true}) {
        Supervisor elbow = led(limits_velocity);
        elbow.begin(at(0, start), start);
        elbow.sent(rad(17), start);
        std::optional<TimePoint> ended;
        for (TimePoint now = start; now <= start + 3s && !ended; now += 10ms) {
            elbow.observe(at(now < start + 1s ? 5.0 * seconds(now - start) : 5.0, now)); // it creeps, then stands
            elbow.sent(rad(30), now);
            if (elbow.judge(at(5, now), position(30), now, now, 10ms, now).measure == Measure::end)
                ended = now;
        }
        EXPECT_EQ(ended.has_value(), !limits_velocity) << "a move of the device is its own affair";
        if (ended) {
            EXPECT_GT(*ended - start, 1800ms);
            EXPECT_LT(*ended - start, 2100ms);
        }
    }
}

/// What `judge` finds when it is looked at every 10 ms for so long.
Measure watched(Supervisor& elbow, const State& looks_like, Mode mode, Duration how_long)
{
    Measure found = Measure::none;
    const Command running{.mode = mode, .position_rad = 0.0};
    for (TimePoint now = start; now <= start + how_long && found == Measure::none; now += 10ms) {
        State state = looks_like;
        state.position_rad = {*looks_like.position_rad, now};
        state.velocity_rad_s = {*looks_like.velocity_rad_s, now};
        if (looks_like.current_a)
            state.current_a = {*looks_like.current_a, now};
        elbow.observe(state);
        found = elbow.judge(state, running, now, now, 10ms, now).measure;
    }
    return found;
}

TEST(Supervisor, AJointThatTurnsTooFastForATenthOfASecondIsStopped)
{
    const auto at_speed = [](double deg_s, Duration how_long, Mode mode = Mode::position) {
        Supervisor elbow = guard(false);
        elbow.begin(at(0, start - 10ms), start - 10ms);
        return watched(elbow, at(0, start, deg_s), mode, how_long);
    };
    // 100 deg/s are allowed, a quarter more is overshoot.
    EXPECT_EQ(at_speed(124, 1s), Measure::none);
    EXPECT_EQ(at_speed(130, 90ms), Measure::none);
    EXPECT_EQ(at_speed(130, 100ms), Measure::stop);
    EXPECT_EQ(at_speed(-130, 100ms), Measure::stop);
    EXPECT_EQ(at_speed(130, 1s, Mode::release), Measure::none) << "by hand it may be faster";
}

TEST(Supervisor, AJointThatTakesTooMuchCurrentForATenthOfASecondIsStopped)
{
    Rules rules{.limits = {.current_max_a = 2.0}, .silence_max = 10s};
    const auto with = [&](double current_a, Duration how_long, Mode mode = Mode::position) {
        Supervisor elbow("elbow", 3, rules, true);
        State state = at(0, start);
        state.current_a = {current_a, start};
        elbow.begin(state, start);
        return watched(elbow, state, mode, how_long);
    };
    EXPECT_EQ(with(2.0, 1s), Measure::none);
    EXPECT_EQ(with(2.1, 90ms), Measure::none) << "to start takes a moment";
    EXPECT_EQ(with(2.1, 100ms), Measure::stop);
    EXPECT_EQ(with(-2.1, 100ms), Measure::stop);
    EXPECT_EQ(with(2.1, 1s, Mode::brake), Measure::none);
}

TEST(Supervisor, ACurrentAndATorqueAreTheSameLimitWhereTheConstantIsKnown)
{
    Rules rules{.limits = {.current_max_a = 4.0, .torque_max_nm = 3.0}};
    const auto admits = [&](const Command& command, std::optional<double> constant) {
        rules.torque_constant_nm_per_a = constant;
        Supervisor elbow("elbow", 3, rules, true);
        elbow.begin(at(0, start), start);
        return elbow.admit(command, at(0, start), start);
    };
    const Command current{.mode = Mode::current, .current_a = -3.1};
    EXPECT_TRUE(admits(current, {}));
    EXPECT_TRUE(admits(current, 0.9));
    const auto refused = admits(current, 1.0);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().detail, "elbow: 3.1 A are 3.1 Nm, more than the 3 Nm allowed");
    const Command torque{.mode = Mode::torque, .torque_nm = 2.9};
    EXPECT_TRUE(admits(torque, 1.0));
    const auto too_strong = admits(torque, 0.5);
    ASSERT_FALSE(too_strong);
    EXPECT_EQ(too_strong.error().detail, "elbow: 2.9 Nm take 5.8 A, more than the 4 A allowed");
    const Command turning{.mode = Mode::velocity, .velocity_rad_s = 0.1, .current_a = 3.1};
    EXPECT_FALSE(admits(turning, 1.0)) << "a velocity pushes as hard";
}

TEST(Supervisor, SilenceTimeOutsHeatAndFaultsAreFound)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(0, start), start);
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = rad(10)};
    const auto judge = [&](const State& state, TimePoint commanded, TimePoint answered, TimePoint now) {
        return elbow.judge(state, turn, commanded, answered, 10ms, now).measure;
    };
    EXPECT_EQ(judge(at(0, start), start, start, start + 200ms), Measure::none);
    EXPECT_EQ(judge(at(0, start), start, start, start + 201ms), Measure::end);
    EXPECT_EQ(judge(at(0, start), start + 400ms, start, start + 501ms), Measure::stop);
    State faulty = at(0, start);
    actuator::Faults faults;
    faults.set(actuator::Fault::unexplained);
    faulty.faults = {faults, start};
    EXPECT_EQ(judge(faulty, start, start, start), Measure::none) << "what nobody explains stops nobody";
    faults.set(actuator::Fault::stall);
    faulty.faults = {faults, start};
    EXPECT_EQ(judge(faulty, start, start, start), Measure::stop);
    State hot = at(0, start);
    hot.temperature_c = {59.0, start};
    EXPECT_EQ(judge(hot, start, start, start), Measure::none);
    hot.temperature_c = {60.0, start};
    EXPECT_EQ(judge(hot, start, start, start), Measure::stop);
}

TEST(Supervisor, AJointThatAnswersWithoutTellingItsPositionIsStopped)
{
    const State unplaced; // as after enabling, or after an answer that tells other things
    const auto after = [&](Duration time, Mode mode = Mode::hold) {
        Supervisor elbow = guard(true);
        elbow.begin(at(0, start - 1s), start);
        elbow.observe(unplaced);
        return elbow.judge(unplaced, {.mode = mode}, start + time, start + time, 10ms, start + time);
    };
    EXPECT_EQ(after(500ms).measure, Measure::none) << "it may be silent for so long, from where it began";
    const auto found = after(501ms);
    EXPECT_EQ(found.measure, Measure::stop);
    EXPECT_EQ(found.why.code, Errc::timeout);
    EXPECT_EQ(found.why.detail.find("elbow: it answers, but has not told its position for 0.50 s"), 0U)
        << found.why.detail;
    EXPECT_EQ(after(501ms, Mode::position).measure, Measure::stop);
    for (const Mode free : {Mode::release, Mode::brake})
        EXPECT_EQ(after(10s, free).measure, Measure::none) << "nobody drives it";
    Supervisor wheel("wheel", 3, {.silence_max = 500ms}, true);
    wheel.begin(unplaced, start);
    EXPECT_EQ(wheel.judge(unplaced, {.mode = Mode::velocity}, start, start + 10s, 10ms, start + 10s).measure,
              Measure::none)
        << "no limit needs its place";
}

TEST(Supervisor, AJointThatFallsSilentIsNotSaidToAnswer)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(0, start), start);
    elbow.observe(at(0, start + 10ms));
    const TimePoint answered = start + 15ms; // with what it was asked for after its position
    EXPECT_EQ(elbow.judge(at(0, start + 10ms), {}, start, answered, 10ms, start + 515ms).measure, Measure::none);
    const auto found = elbow.judge(at(0, start + 10ms), {}, start, answered, 10ms, start + 516ms);
    EXPECT_EQ(found.measure, Measure::stop);
    EXPECT_NE(found.why.detail.find("it has not answered for 0.50 s"), std::string::npos) << found.why.detail;
}

TEST(Supervisor, AJointOfASlowBusMayTellItsPositionInEverySecondCycle)
{
    Supervisor elbow = guard(true);
    elbow.begin(at(0, start), start);
    State seen;
    for (int cycle = 0; cycle < 6; ++cycle) {
        const TimePoint answered = start + cycle * 400ms;
        if (cycle % 2 == 0)
            seen = at(0, answered);
        elbow.observe(seen);
        for (const TimePoint now : {answered, answered + 400ms})
            EXPECT_EQ(elbow.judge(seen, {}, now, answered, 400ms, now).measure, Measure::none) << cycle;
    }
}

TEST(Mounting, GoesThereAndBack)
{
    const Mounting mounting{.direction = -1.0, .ratio = 2.5, .zero_rad = 0.7};
    EXPECT_NEAR(mounting.to_joint(mounting.to_actuator(0.4)), 0.4, 1e-12);
    EXPECT_NEAR(mounting.zero_rad_at(mounting.to_actuator(0.4), 0.4), mounting.zero_rad, 1e-12);
    const Command torque = mounting.to_actuator(Command{.mode = Mode::torque, .torque_nm = 5.0});
    EXPECT_NEAR(*torque.torque_nm, -2.0, 1e-12) << "the gear does the rest";
    const Command limit =
        mounting.to_actuator(Command{.mode = Mode::velocity, .velocity_rad_s = 1.0, .current_a = 2.0});
    EXPECT_NEAR(*limit.velocity_rad_s, -2.5, 1e-12);
    EXPECT_NEAR(*limit.current_a, 2.0, 1e-12) << "a limit has no sense";
    actuator::Capabilities can{.position_low_rad = -1.0, .position_high_rad = 3.0};
    const auto joint = mounting.to_joint(can);
    EXPECT_LT(*joint.position_low_rad, *joint.position_high_rad);
}

} // namespace
} // namespace sinew::robot
