#include "sinew/robot/trajectory.hpp"

#include "tests/support/random.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::test {
namespace {

using robot::MotionLimits;
using robot::Setpoint;
using robot::Trajectory;

struct Case {
    double from = 0.0, velocity = 0.0, target = 0.0;
    MotionLimits limits;

    std::string words() const
    {
        return fmt::format("from {} at {} to {} within v {} a {} j {}", from, velocity, target, limits.velocity_rad_s,
                           limits.acceleration_rad_s2, limits.jerk_rad_s3);
    }
};

double real(Random& random, double low, double high)
{
    return low + (high - low) * (static_cast<double>(random.bits() >> 11U) * 0x1.0p-53);
}

/// Of any size between the two.
double scale(Random& random, double low, double high)
{
    return std::exp(real(random, std::log(low), std::log(high)));
}

Case any_case(Random& random)
{
    Case out;
    out.limits = {.velocity_rad_s = scale(random, 0.05, 50), .acceleration_rad_s2 = scale(random, 0.1, 500)};
    if (!random.one_in(4))
        out.limits.jerk_rad_s3 = scale(random, 0.5, 5e4);
    out.from = real(random, -7, 7);
    out.target = random.one_in(10) ? out.from : out.from + (random.one_in(2) ? 1 : -1) * scale(random, 1e-6, 20);
    if (!random.one_in(3))
        out.velocity = out.limits.velocity_rad_s * real(random, -1, 1);
    return out;
}

/// Walks through a motion in steps that hit the ends of its segments closely.
template <class Look>
void walk(const Trajectory& motion, Look look)
{
    constexpr int steps = 200;
    for (int i = 0; i <= steps; ++i)
        look(motion.duration() * i / steps);
}

void expect_within_limits(const Trajectory& motion, const Case& of)
{
    constexpr double slack = 1.0 + 1e-9;
    walk(motion, [&](Duration t) {
        const Setpoint now = motion.at(t);
        ASSERT_LE(std::abs(now.velocity_rad_s), of.limits.velocity_rad_s * slack) << of.words();
        ASSERT_LE(std::abs(now.acceleration_rad_s2), of.limits.acceleration_rad_s2 * slack) << of.words();
    });
}

/// Velocity is the slope of the position, acceleration that of the velocity, and the acceleration has no more than the
/// jerk: over every step, as the mean value theorem has it.
void expect_continuous(const Trajectory& motion, const Case& of)
{
    Setpoint before = motion.at(Duration{});
    Duration time_before{};
    walk(motion, [&](Duration t) {
        const Setpoint now = motion.at(t);
        const double dt = seconds(t - time_before);
        const double size = 1.0 + std::abs(now.position_rad) + std::abs(of.target - of.from);
        const double rounding = 1e-12 * size;
        ASSERT_LE(std::abs(now.velocity_rad_s - before.velocity_rad_s),
                  of.limits.acceleration_rad_s2 * dt * (1 + 1e-9) + rounding * 100)
            << of.words();
        const double by_slope = (now.velocity_rad_s + before.velocity_rad_s) / 2.0 * dt;
        ASSERT_NEAR(now.position_rad - before.position_rad, by_slope,
                    of.limits.acceleration_rad_s2 * dt * dt / 2.0 + rounding)
            << of.words();
        if (std::isfinite(of.limits.jerk_rad_s3)) {
            ASSERT_LE(std::abs(now.acceleration_rad_s2 - before.acceleration_rad_s2),
                      of.limits.jerk_rad_s3 * dt * (1 + 1e-6) + 1e-7 * of.limits.acceleration_rad_s2)
                << of.words();
        }
        before = now;
        time_before = t;
    });
}

void expect_good(const Trajectory& motion, const Case& of)
{
    const Setpoint first = motion.at(Duration{}), last = motion.at(motion.duration());
    ASSERT_EQ(first.position_rad, of.from) << of.words();
    ASSERT_EQ(first.velocity_rad_s, of.velocity) << of.words();
    ASSERT_EQ(last.position_rad, of.target) << of.words();
    ASSERT_EQ(last.velocity_rad_s, 0.0) << of.words();
    expect_within_limits(motion, of);
    expect_continuous(motion, of);
}

TEST(TrajectoryProperty, LimitsAreKeptNothingJumpsAndTheEndIsExact)
{
    Random random("trajectory");
    for (std::uint64_t i = 0; i < cases() && !testing::Test::HasFatalFailure(); ++i) {
        const Case of = any_case(random);
        const auto motion = Trajectory::plan(of.from, of.velocity, of.target, of.limits);
        ASSERT_TRUE(motion) << of.words();
        expect_good(*motion, of);
    }
}

TEST(TrajectoryProperty, ALongerMotionKeepsTheLimitsAndTakesExactlyAsLong)
{
    Random random("stretched");
    std::uint64_t left_out = 0;
    for (std::uint64_t i = 0; i < cases() && !testing::Test::HasFatalFailure(); ++i) {
        const Case of = any_case(random);
        const auto soonest = Trajectory::plan(of.from, of.velocity, of.target, of.limits);
        ASSERT_TRUE(soonest) << of.words();
        const double factor = random.one_in(2) ? real(random, 1, 1.2) : scale(random, 1, 50);
        const Duration asked{static_cast<std::int64_t>(seconds(soonest->duration()) * factor * 1e9) + 1};
        const Duration longer = soonest->reachable(asked);
        ASSERT_GE(longer, asked) << of.words();
        left_out += longer != asked ? 1 : 0;
        const auto motion = soonest->lasting(longer);
        ASSERT_TRUE(motion) << of.words() << ": " << to_sentence(motion.error());
        ASSERT_LE(std::abs((motion->duration() - longer).count()), 1) << of.words();
        expect_good(*motion, of);
    }
    EXPECT_LT(left_out, cases() / 10) << "most durations can be had";
}

/// Another way to the same end, in small steps: the hardest push with which it can still come to rest before the
/// target, asked anew at every step. It knows no ramps and no formula.
class Greedy
{
public:
    Greedy(const Case& of, double step_s) : of_(of), dt_(step_s) {}

    struct Found {
        double way_rad = 0.0; ///< a little short of the target
        double duration_s = 0.0;
    };

    /// From rest; nothing when it takes longer than this.
    std::optional<Found> search(double most_s) const
    {
        const double way = std::abs(of_.target - of_.from);
        State now;
        for (double t = 0.0; t < most_s; t += dt_) {
            for (const double jerk : {of_.limits.jerk_rad_s3, 0.0, -of_.limits.jerk_rad_s3}) {
                const State next = step(now, jerk);
                const bool last_choice = jerk < 0.0;
                if (last_choice || can_stop(next, way)) {
                    now = next;
                    break;
                }
            }
            if (now.v <= 0.0 && t > dt_)
                return Found{now.x, t + std::abs(now.a) / of_.limits.jerk_rad_s3}; // the brakes still have to let go
        }
        return std::nullopt;
    }

private:
    struct State {
        double x = 0.0, v = 0.0, a = 0.0;
    };

    State step(const State& s, double jerk) const
    {
        const double most = of_.limits.acceleration_rad_s2;
        const double a = std::clamp(s.a + jerk * dt_, -most, most);
        const double mean = (s.a + a) / 2.0;
        return {s.x + s.v * dt_ + mean * dt_ * dt_ / 2.0, s.v + mean * dt_, a};
    }

    bool can_stop(State s, double way) const
    {
        const double j = of_.limits.jerk_rad_s3;
        if (s.a > 0.0 && s.v + s.a * s.a / (2.0 * j) > of_.limits.velocity_rad_s)
            return false;
        while (s.v > 0.0) {
            const bool let_go = s.a < 0.0 && s.v <= s.a * s.a / (2.0 * j);
            s = step(s, let_go ? j : -j);
            if (s.x > way)
                return false;
            if (let_go && s.a >= 0.0)
                break;
        }
        return true;
    }

    Case of_;
    double dt_;
};

TEST(TrajectoryProperty, NoMotionThatAStepByStepSearchFindsIsSooner)
{
    Random random("greedy");
    double worst = 0.0;
    for (std::uint64_t i = 0; i < std::max<std::uint64_t>(20, cases() / 200); ++i) {
        Case of = any_case(random);
        of.velocity = 0.0;
        if (!std::isfinite(of.limits.jerk_rad_s3))
            of.limits.jerk_rad_s3 = scale(random, 0.5, 5e4);
        // Not much longer than its ramps, which the steps must be small for.
        const auto& most = of.limits;
        const double ramp_s = robot::Ramp(0.0, most.velocity_rad_s, most).duration_s();
        of.target = of.from + (random.one_in(2) ? 1 : -1) * scale(random, 0.01, 3) * most.velocity_rad_s * ramp_s;
        const auto motion = Trajectory::plan(of.from, 0.0, of.target, of.limits);
        ASSERT_TRUE(motion);
        constexpr double steps = 2000.0;
        const double expected_s = seconds(motion->duration());
        const auto found = Greedy(of, expected_s / steps).search(expected_s * 1.5);
        ASSERT_TRUE(found) << of.words();
        ASSERT_NEAR(found->way_rad / std::abs(of.target - of.from), 1.0, 0.05) << of.words();
        const auto there = Trajectory::plan(0.0, 0.0, found->way_rad, of.limits);
        ASSERT_TRUE(there);
        const double ratio = found->duration_s / seconds(there->duration());
        worst = std::max(worst, std::abs(ratio - 1.0));
        ASSERT_NEAR(ratio, 1.0, 0.03) << of.words();
    }
    fmt::print("the search came within {:.2f} %\n", 100.0 * worst);
}

/// Drives for a while with random jerks and then stops: some motion within the limits that ends at rest.
TEST(TrajectoryProperty, NoRandomMotionWithinTheLimitsIsSooner)
{
    Random random("random drive");
    for (std::uint64_t i = 0; i < cases(); ++i) {
        Case of = any_case(random);
        const double most_v = of.limits.velocity_rad_s;
        if (!std::isfinite(of.limits.jerk_rad_s3))
            of.limits.jerk_rad_s3 = 1e3;
        // A chain of ramps between random velocities and cruises between them.
        double x = 0.0, v = of.velocity, t = 0.0;
        for (std::uint64_t part = 0; part < 1 + random.below(3); ++part) {
            const double next = real(random, -most_v, most_v);
            const robot::Ramp ramp(v, next, of.limits);
            const double cruise = random.one_in(2) ? 0.0 : scale(random, 1e-3, 3);
            x += ramp.distance_rad() + next * cruise;
            t += ramp.duration_s() + cruise;
            v = next;
        }
        const robot::Ramp last(v, 0.0, of.limits);
        const auto motion = Trajectory::plan(0.0, of.velocity, x + last.distance_rad(), of.limits);
        ASSERT_TRUE(motion) << of.words();
        ASSERT_LE(seconds(motion->duration()), (t + last.duration_s()) * (1 + 1e-9) + 2e-9) << of.words();
    }
}

} // namespace
} // namespace sinew::test
