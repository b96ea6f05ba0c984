#include "sinew/sim/firmware/nuri_for_tests.hpp"

#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

using test::covers;
using namespace std::chrono_literals;
using enum nuri::Rotation;

TEST(NuriMotion, ArrivesAtTheCommandedSpeed)
{
    covers("B 6");
    const auto spec = spec_of();
    NuriBench bench(spec);
    const double velocity = units::rad_s_from_rpm(5.0);
    const double distance = units::rad(90.0);
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 9000, 50});
    const double time_s = distance / velocity + velocity / rating_of(spec).acceleration_max_rad_s2;
    bench.run(1s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, velocity, 1e-6);
    int steps = 1000;
    while (std::abs(bench.device.look().position_rad - distance) > rest_rad && ++steps < 10'000)
        bench.run(1ms);
    EXPECT_NEAR(steps, time_s * 1000.0, settle_ms);
}

TEST(NuriMotion, ReachesAPositionInTheGivenTime)
{
    covers("B 6");
    NuriBench bench(spec_of());
    bench.send(nuri::AccelPositionControl{clockwise, 18'000, 20});
    int steps = 0;
    while (std::abs(bench.device.look().position_rad - units::rad(-180.0)) > rest_rad && ++steps < 10'000)
        bench.run(1ms);
    EXPECT_NEAR(steps, 2000, settle_ms);
}

TEST(NuriMotion, ReachesASpeedInTheGivenTimeByALinearRamp)
{
    covers("B 6");
    NuriBench bench(spec_of());
    bench.send(nuri::AccelSpeedControl{clockwise, 100, 10});
    const double two_ticks = units::rad_s_from_rpm(10.0) * 0.002; // of the ramp
    bench.run(500ms);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, units::rad_s_from_rpm(-5.0), two_ticks);
    bench.run(500ms);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, units::rad_s_from_rpm(-10.0), two_ticks);
    const auto feedback = bench.ask(nuri::RequestSpeedFeedback{});
    EXPECT_EQ(feedback.speed_direction, clockwise);
    EXPECT_EQ(feedback.speed, 100);
}

/// By a ramp that begins where its drive wants it to be, which the shaft follows a little later.
TEST(NuriMotion, ComesToRestInTheGivenTimeAlsoWhereItTurnsRoundJustThen)
{
    NuriBench bench(spec_of());
    bench.send(nuri::AccelSpeedControl{clockwise, 100, 5});
    bench.run(600ms);
    bench.send(nuri::AccelSpeedControl{counter_clockwise, 100, 5});
    while (bench.device.look().velocity_rad_s < 0.0)
        bench.run(1ms);
    bench.send(nuri::AccelSpeedControl{clockwise, 0, 1});
    bench.run(300ms);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, 0.0, 1e-3);
}

/// Its trajectory waited for the shaft, and begins anew from where and how fast that is.
TEST(NuriMotion, ComesToRestAfterItWasPushedThoughItWasAtRestWhenItWasToldTo)
{
    NuriBench bench(spec_of());
    bench.send(nuri::AccelSpeedControl{clockwise, 0, 1});
    bench.run(200ms);
    bench.device.plant().push(100.0);
    bench.run(100ms);
    bench.device.plant().push(0.0);
    EXPECT_GT(std::abs(bench.device.look().velocity_rad_s), 1.0);
    bench.run(3s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, 0.0, 1e-3);
}

/// To and fro by more than its current can: the trajectory is ahead of the shaft, and must not be far ahead.
TEST(NuriMotion, ComesToRestSoonAlsoWhereItCouldNotFollow)
{
    for (int until_ms = 300; until_ms < 1500; until_ms += 70) {
        NuriBench bench(spec_of());
        for (int ms = 0; ms < until_ms; ms += 10) {
            const double rpm = 4.0 * std::sin(6.0 * ms / 1000.0 + 0.7);
            bench.send(nuri::AccelSpeedControl{rpm < 0 ? clockwise : counter_clockwise,
                                               static_cast<std::uint16_t>(std::lround(std::abs(rpm) * 10.0)), 10});
            bench.run(10ms);
        }
        bench.send(nuri::AccelSpeedControl{clockwise, 0, 1});
        bench.run(500ms);
        EXPECT_NEAR(bench.device.look().velocity_rad_s, 0.0, 1e-3) << until_ms;
    }
}

TEST(NuriMotion, TellsPositionsInHundredthsAndInSpeedFeedbackInTenths)
{
    covers("B 13");
    auto spec = spec_of();
    spec.device.start_rad = units::rad(-123.45);
    NuriBench bench(spec);
    const auto near = bench.ask(nuri::RequestPositionFeedback{});
    EXPECT_EQ(near.position_direction, clockwise);
    EXPECT_EQ(near.position, 12'345);
    EXPECT_EQ(near.speed, 0);
    const auto far = bench.ask(nuri::RequestSpeedFeedback{});
    EXPECT_EQ(far.speed_direction, counter_clockwise);
    EXPECT_NEAR(far.position, 1234.5, 0.5);
}

TEST(NuriMotion, ClampsOrWrapsPositionsBeyondItsFeedback)
{
    auto spec = spec_of();
    spec.device.start_rad = units::rad(700.0);
    EXPECT_EQ(NuriBench(spec).ask(nuri::RequestPositionFeedback{}).position, 65'533);
    EXPECT_EQ(NuriBench(spec).ask(nuri::RequestSpeedFeedback{}).position, 7000);
    spec.profile.position_feedback_limit = nuri::PositionFeedbackLimit::wrap;
    EXPECT_EQ(NuriBench(spec).ask(nuri::RequestPositionFeedback{}).position, 70'000 - 65'534);
}

TEST(NuriMotion, TurnsCounterClockwiseToThePositiveSideUnlessTheProfileSaysOtherwise)
{
    for (const bool positive : {true, false}) {
        auto spec = spec_of();
        spec.profile.ccw_positive = positive;
        NuriBench bench(spec);
        bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
        bench.run(5s);
        EXPECT_NEAR(bench.device.look().position_rad, units::rad(positive ? 10.0 : -10.0), rest_rad);
        EXPECT_EQ(bench.ask(nuri::RequestPositionFeedback{}).position_direction, counter_clockwise);
    }
}

TEST(NuriMotion, AddsRelativePositionsToWhereItIs)
{
    covers("B 10");
    NuriBench bench(spec_of());
    bench.send(nuri::SetPositionControlMode{.position_mode = nuri::PositionMode::relative});
    for (int i = 0; i < 2; ++i) {
        bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
        bench.run(5s);
    }
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(20.0), rest_rad);
}

TEST(NuriMotion, CallsThePresentPositionZero)
{
    covers("B 11");
    NuriBench bench(spec_of());
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
    bench.run(5s);
    bench.send(nuri::ResetPosition{});
    EXPECT_EQ(bench.ask(nuri::RequestPositionFeedback{}).position, 0);
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(20.0), rest_rad);
}

TEST(NuriMotion, GoesToItsZeroAtAPositionResetWhenBuiltSo)
{
    covers("B 11");
    auto spec = spec_of();
    spec.device.position_reset = nuri::PositionReset::go_to_zero;
    NuriBench bench(spec);
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
    bench.run(5s);
    bench.send(nuri::ResetPosition{});
    EXPECT_EQ(bench.ask(nuri::RequestPositionFeedback{}).position, 1000);
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().position_rad, 0.0, rest_rad);
}

TEST(NuriMotion, MeansTheShaftBehindTheExternalGear)
{
    covers("B 8");
    NuriBench bench(spec_of());
    bench.send(nuri::SetExternalGearRatio{.gear_ratio = 30});
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
    bench.run(500ms);
    EXPECT_EQ(bench.ask(nuri::RequestPositionFeedback{}).position, 1000);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(30.0), rest_rad);
}

TEST(NuriMotion, InvertsItsDirectionOfControl)
{
    covers("B 14");
    NuriBench bench(spec_of());
    bench.send(nuri::SetControlDirection{.control_direction = 1});
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(-10.0), rest_rad);
    EXPECT_EQ(bench.ask(nuri::RequestPositionFeedback{}).position_direction, counter_clockwise);
}

TEST(NuriMotion, DrawsNoMoreThanTheRatedCurrentOfItsController)
{
    covers("B 7");
    NuriBench bench(spec_of());
    bench.send(nuri::SetPositionController{
        .position_kp = 100, .position_ki = 10, .position_kd = 10, .position_rated_current = 3});
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 18'000, 400});
    double most = 0.0;
    for (int i = 0; i < 4000; ++i) {
        bench.run(1ms);
        most = std::max(most, std::abs(bench.device.look().current_a));
    }
    EXPECT_LE(most, 0.3 + 1e-9);
    EXPECT_GT(most, 0.2);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(180.0), rest_rad);
}

TEST(NuriMotion, GivesWayTheFurtherTheSmallerKp)
{
    covers("B 7");
    double way[2] = {};
    for (const bool soft : {false, true}) {
        NuriBench bench(spec_of());
        bench.send(nuri::SetPositionController{.position_kp = static_cast<std::uint8_t>(soft ? 10 : 100),
                                               .position_ki = 0,
                                               .position_kd = 10,
                                               .position_rated_current = 10});
        bench.send(nuri::PositionSpeedControl{counter_clockwise, 0, 100});
        bench.device.plant().push(1.0);
        bench.run(2s);
        way[soft] = bench.device.look().position_rad;
    }
    // Friction holds against a part of the push, the same in both.
    EXPECT_GT(way[0], 0.0);
    EXPECT_NEAR(way[1] / way[0], 10.0, 1.0);
}

TEST(NuriMotion, GoesOnSlowlyWhenItComesFree)
{
    NuriBench bench(spec_of());
    bench.device.plant().jam(true);
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 9000, 50});
    bench.run(3s);
    bench.device.plant().jam(false);
    double most = 0.0;
    for (int i = 0; i < 5000; ++i) {
        bench.run(1ms);
        most = std::max(most, bench.device.look().velocity_rad_s);
    }
    EXPECT_LT(most, 2.0 * units::rad_s_from_rpm(5.0));
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(90.0), rest_rad);
}

TEST(NuriMotion, AddsRelativePositionsToTheTargetWhenBuiltSo)
{
    covers("B 10");
    for (const auto base : {nuri::RelativeBase::position, nuri::RelativeBase::target}) {
        auto spec = spec_of();
        spec.device.relative_base = base;
        NuriBench bench(spec);
        bench.send(nuri::SetPositionControlMode{.position_mode = nuri::PositionMode::relative});
        for (int i = 0; i < 2; ++i)
            bench.send(nuri::PositionSpeedControl{counter_clockwise, 1000, 100});
        bench.run(5s);
        EXPECT_NEAR(bench.device.look().position_rad, units::rad(base == nuri::RelativeBase::target ? 20.0 : 10.0),
                    rest_rad);
    }
}

} // namespace
} // namespace sinew::sim
