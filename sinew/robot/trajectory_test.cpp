#include "sinew/robot/trajectory.hpp"

#include "tests/support/allocations.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;

constexpr MotionLimits s_curve{.velocity_rad_s = 2.0, .acceleration_rad_s2 = 4.0, .jerk_rad_s3 = 16.0};
constexpr MotionLimits trapezoid{.velocity_rad_s = 2.0, .acceleration_rad_s2 = 4.0};

Trajectory planned(double from, double velocity, double target, const MotionLimits& limits)
{
    auto out = Trajectory::plan(from, velocity, target, limits);
    EXPECT_TRUE(out) << to_sentence(out.error());
    return out.value_or(Trajectory{});
}

double duration_s(const Trajectory& trajectory)
{
    return seconds(trajectory.duration());
}

std::string complaint(double from, double velocity, double target, const MotionLimits& limits)
{
    const auto out = Trajectory::plan(from, velocity, target, limits);
    return out ? "nothing" : to_sentence(out.error());
}

TEST(Trajectory, ATrapezoidTakesAsLongAsTheTextbookSays)
{
    // v/a to speed up, v/a to slow down, and the rest at v.
    EXPECT_NEAR(duration_s(planned(0, 0, 3, trapezoid)), 0.5 + 0.5 + (3.0 - 1.0) / 2.0, 1e-9);
    // A short way never reaches v: 2 sqrt(d/a).
    EXPECT_NEAR(duration_s(planned(1, 0, 1.25, trapezoid)), 2.0 * std::sqrt(0.25 / 4.0), 1e-9);
}

TEST(Trajectory, AnSCurveTakesAsLongAsTheTextbookSays)
{
    // d/v + v/a + a/j with all seven segments.
    EXPECT_NEAR(duration_s(planned(0, 0, -3, s_curve)), 3.0 / 2.0 + 2.0 / 4.0 + 4.0 / 16.0, 1e-9);
    // Without reaching a: four segments of (d/2j)^(1/3).
    EXPECT_NEAR(duration_s(planned(0, 0, 0.001, s_curve)), 4.0 * std::cbrt(0.001 / (2.0 * 16.0)), 1e-9);
}

TEST(Trajectory, AMotionBeginsWhereItsJointIsAndEndsAtRestOnTheTarget)
{
    const auto motion = planned(0.3, 1.0, 2.7, s_curve);
    EXPECT_EQ(motion.at(0ns).position_rad, 0.3);
    EXPECT_EQ(motion.at(0ns).velocity_rad_s, 1.0);
    EXPECT_EQ(motion.at(-1s).position_rad, 0.3);
    for (const Duration after : {Duration{0ns}, Duration{1ns}, Duration{1s}, Duration{1000s}}) {
        EXPECT_EQ(motion.at(motion.duration() + after).position_rad, 2.7);
        EXPECT_EQ(motion.at(motion.duration() + after).velocity_rad_s, 0.0);
    }
    EXPECT_NEAR(motion.at(motion.duration() - 1us).position_rad, 2.7, 1e-12);
}

TEST(Trajectory, HalfwayThroughAMotionFromRestItIsHalfwayThere)
{
    const auto motion = planned(1, 0, 3, s_curve);
    EXPECT_NEAR(motion.at(motion.duration() / 2).position_rad, 2.0, 1e-9);
    EXPECT_NEAR(motion.at(motion.duration() / 2).velocity_rad_s, 2.0, 1e-9);
}

TEST(Trajectory, AMotionToWhereItIsTakesNoTime)
{
    const auto motion = planned(0.5, 0, 0.5, s_curve);
    EXPECT_EQ(motion.duration(), 0ns);
    EXPECT_EQ(motion.at(0ns).position_rad, 0.5);
    const auto waiting = motion.lasting(2s);
    ASSERT_TRUE(waiting);
    EXPECT_EQ(waiting->duration(), 2s);
    EXPECT_EQ(waiting->at(1s).position_rad, 0.5);
}

TEST(Trajectory, AStartThatIsTooFastGoesPastTheTargetAndComesBack)
{
    const auto motion = planned(0, 2.0, 0.1, trapezoid);
    // It stands after v/a, at v²/2a = 0.5, and has 0.4 to come back.
    EXPECT_NEAR(motion.at(500ms).position_rad, 0.5, 1e-9);
    EXPECT_NEAR(duration_s(motion), 0.5 + 2.0 * std::sqrt(0.4 / 4.0), 1e-9);
}

TEST(Trajectory, AStartBeyondTheLimitComesDownToItFirst)
{
    const auto motion = planned(0, 6.0, 20.0, trapezoid);
    EXPECT_NEAR(motion.at(1s).velocity_rad_s, 2.0, 1e-9); // from 6 to 2 at 4 rad/s²
    EXPECT_NEAR(motion.at(2s).velocity_rad_s, 2.0, 1e-9);
}

TEST(Trajectory, AStopEndsWhereTheBrakesEnd)
{
    const auto motion = Trajectory::stop(1.0, -2.0, trapezoid);
    ASSERT_TRUE(motion);
    EXPECT_EQ(motion->duration(), 500ms);
    EXPECT_NEAR(motion->target_rad(), 0.5, 1e-12);
    EXPECT_EQ(Trajectory::stop(1.0, 0.0, s_curve)->duration(), 0ns);
    EXPECT_EQ(Trajectory::stop(1.0, 0.0, s_curve)->target_rad(), 1.0);
}

TEST(Trajectory, FromRestALongerMotionIsTheSameOneSlower)
{
    const auto soonest = planned(0, 0, 3, s_curve);
    const auto twice = soonest.lasting(2 * soonest.duration());
    ASSERT_TRUE(twice);
    EXPECT_EQ(twice->duration(), 2 * soonest.duration());
    for (const Duration t : {100ms, 500ms, 900ms, 1700ms}) {
        EXPECT_NEAR(twice->at(2 * t).position_rad, soonest.at(t).position_rad, 1e-9);
        EXPECT_NEAR(twice->at(2 * t).velocity_rad_s, soonest.at(t).velocity_rad_s / 2, 1e-9);
        EXPECT_NEAR(twice->at(2 * t).acceleration_rad_s2, soonest.at(t).acceleration_rad_s2 / 4, 1e-8);
    }
}

TEST(Trajectory, AMotionIsNotSqueezedBelowItsShortestDuration)
{
    const auto motion = planned(0, 0, 3, s_curve);
    const auto squeezed = motion.lasting(1s);
    ASSERT_FALSE(squeezed);
    EXPECT_EQ(squeezed.error().code, Errc::out_of_range);
    EXPECT_EQ(to_sentence(squeezed.error()), "this motion cannot take 1 s; it can take 2.25 s");
    // What was stretched may be shortened again.
    EXPECT_EQ(motion.lasting(9s)->lasting(3s)->duration(), 3s);
}

TEST(Trajectory, AMovingStartSaysWhichDurationsItCannotHave)
{
    // It would stop within 0.75 rad: at 0.751 it arrives almost at once or comes to rest first.
    const auto motion = planned(0, 2.0, 0.751, s_curve);
    EXPECT_NEAR(duration_s(motion), 0.75, 2e-3);
    const auto next = motion.reachable(motion.duration() + 10ms);
    EXPECT_GT(next, motion.duration() + 10ms);
    EXPECT_FALSE(motion.lasting(motion.duration() + 10ms));
    const auto longer = motion.lasting(next);
    ASSERT_TRUE(longer) << to_sentence(longer.error());
    EXPECT_EQ(longer->duration(), next);
    EXPECT_EQ(motion.reachable(next + 1ms), next + 1ms);
}

TEST(Trajectory, NumbersThatMakeNoSenseAreRefused)
{
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double inf = std::numeric_limits<double>::infinity();
    const std::string no_number = "a motion needs a start and a target that are finite numbers";
    EXPECT_EQ(complaint(nan, 0, 1, s_curve), no_number);
    EXPECT_EQ(complaint(0, inf, 1, s_curve), no_number);
    EXPECT_EQ(complaint(0, 0, -inf, s_curve), no_number);
    const std::string no_limit = "the greatest velocity, acceleration and jerk of a motion must be above 0";
    EXPECT_EQ(complaint(0, 0, 1, {0.0, 1.0, 1.0}), no_limit);
    EXPECT_EQ(complaint(0, 0, 1, {1.0, inf, 1.0}), no_limit);
    EXPECT_EQ(complaint(0, 0, 1, {1.0, 1.0, nan}), no_limit);
    EXPECT_EQ(complaint(0, 0, 1e30, s_curve), "a motion within these limits would take more than 30 years");
}

TEST(Trajectory, SamplingAsksNothingOfTheHeap)
{
    const auto motion = planned(0, 0.5, 3, s_curve);
    const auto before = support::allocations();
    double sum = 0.0;
    for (Duration t{}; t < motion.duration(); t += 1ms)
        sum += motion.at(t).position_rad;
    EXPECT_EQ(support::allocations(), before);
    EXPECT_GT(sum, 0.0);
}

} // namespace
} // namespace sinew::robot
