#include "sinew/robot/stillness.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;
using units::rad;

constexpr double steps_deg[] = {0.083, 0.01, 0.01 / 9.0, 0.5}; ///< SAM, Nuri, RMD, and a coarse one
constexpr Duration gaps[] = {3ms, 10ms, 20ms, 100ms, 150ms};   ///< between two looks

/// How long it takes to be seen at rest, with looks at where it is, as the device tells that; nothing: not in 5 s.
std::optional<Duration> rests_after(double step_deg, Duration gap, const std::function<double(double time_s)>& deg)
{
    Stillness stillness(rad(step_deg));
    for (Duration time{}; time < 5s; time += gap) {
        stillness.look({rad(step_deg * std::round(deg(seconds(time)) / step_deg)), TimePoint{1s} + time});
        if (stillness.is_at_rest())
            return time;
    }
    return {};
}

TEST(Stillness, AJointThatCreepsIsNotAtRestHoweverCoarseItsPositionIs)
{
    for (const double step : steps_deg)
        for (const Duration gap : gaps)
            for (const double phase : {0.0, 0.2, 0.4, 0.6, 0.8})
                for (const double deg_s : {1.6, -1.6, 1.05})
                    EXPECT_FALSE(rests_after(step, gap, [&](double s) { return phase * step + deg_s * s; }))
                        << step << " deg, looked at every " << seconds(gap) << " s, at " << deg_s << " deg/s";
}

TEST(Stillness, AJointWhosePositionFlickersByOneStepIsAtRest)
{
    for (const double step : {0.083, 0.01, 0.01 / 9.0})
        for (const Duration gap : gaps) {
            bool odd = false;
            const auto after = rests_after(step, gap, [&](double) { return 40.0 + ((odd = !odd) ? step : 0.0); });
            ASSERT_TRUE(after) << step;
            EXPECT_GE(*after, Stillness::least);
            EXPECT_LE(*after, std::max<Duration>(170ms + gap, 2 * gap)) << "two steps of a SAM at 1 deg/s";
        }
    bool odd = false;
    EXPECT_TRUE(rests_after(0.5, 100ms, [&](double) { return (odd = !odd) ? 0.5 : 0.0; })) << "it takes a second";
}

TEST(Stillness, AJointThatStandsIsAtRestAfterThreeLooksOrATenthOfASecond)
{
    for (const double step : {0.083, 0.01, 0.01 / 9.0}) {
        EXPECT_EQ(rests_after(step, 10ms, [](double) { return 12.0; }), 100ms);
        EXPECT_EQ(rests_after(step, 100ms, [](double) { return 12.0; }), 200ms);
    }
}

TEST(Stillness, AJointThatTurnsRoundIsNotAtRest)
{
    for (const Duration gap : gaps)
        EXPECT_FALSE(rests_after(0.01, gap, [](double s) { return 2.0 * std::cos(2.0 * std::numbers::pi * 2.0 * s); }))
            << "it swings twice a second";
}

TEST(Stillness, AJointThatComesToRestIsSeenToBeInTheTimeOfItsLooks)
{
    const auto after = rests_after(0.01, 10ms, [](double s) { return s < 1.0 ? 30.0 * s : 30.0; });
    ASSERT_TRUE(after);
    EXPECT_GT(*after, 1s);
    EXPECT_LE(*after, 1s + 300ms) << "of the last third of a degree it is not known how fast it was";
}

TEST(Stillness, ALookThatMeasuresNothingNewTellsNothing)
{
    Stillness stillness(rad(0.01));
    for (int i = 0; i < 100; ++i)
        stillness.look({1.0, TimePoint{1s}});
    EXPECT_FALSE(stillness.is_at_rest());
    stillness.look({});
    for (const Duration time : {2s, 3s})
        stillness.look({1.0, TimePoint{time}});
    EXPECT_TRUE(stillness.is_at_rest());
    stillness.begin();
    EXPECT_FALSE(stillness.is_at_rest());
    for (const Duration time : {4s, 5s})
        stillness.look({1.0, TimePoint{time}});
    EXPECT_FALSE(stillness.is_at_rest()) << "what was seen before counts";
}

} // namespace
} // namespace sinew::robot
