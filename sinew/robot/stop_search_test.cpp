#include "sinew/robot/stop_search.hpp"

#include "sinew/base/seconds.hpp"

#include <functional>
#include <gtest/gtest.h>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;

constexpr double speed_rad_s = 0.5;
constexpr Duration turns_for = 2s; ///< before it stands

/// How long after it has come to stand that passes for its stop, with the current that it reads while it stands;
/// nothing: not in `within`.
std::optional<Duration> found_after(Duration between_looks, const std::function<double(int look)>& current_a,
                                    Duration within)
{
    config::Joint joint;
    joint.home.velocity_rad_s = speed_rad_s;
    joint.home.travel_max_rad = 10.0;
    const TimePoint begin{5s};
    StopSearch search(joint, 0.0, begin);
    for (int look = 1;; ++look) {
        const Duration time = look * between_looks;
        if (time > turns_for + within)
            return {};
        const bool stands = time > turns_for;
        const TimePoint now = begin + time;
        const auto seen = search.look({speed_rad_s * seconds(std::min(time, turns_for)), now},
                                      {stands ? current_a(look) : 0.0, now}, now);
        if (seen != StopSearch::Seen::way)
            return seen == StopSearch::Seen::stop ? std::optional(time - turns_for) : std::nullopt;
    }
}

TEST(StopSearch, WhatStandsAndPushesHasFoundItsStop)
{
    const auto found = found_after(10ms, [](int) { return -0.3; }, 1s);
    ASSERT_TRUE(found);
    EXPECT_LE(*found, 2 * StopSearch::stand_still);
}

/// It has started afresh, and does not turn until it is told again.
TEST(StopSearch, WhatStandsFreeAndReadsAStepOfCurrentNowAndThenHasNotFoundItsStop)
{
    for (const Duration gap : {Duration(10ms), Duration(50ms), Duration(110ms), Duration(250ms)})
        for (const int rarely : {2, 3, 5, 10})
            for (int phase = 0; phase < rarely; ++phase) {
                const auto a_step = [&](int look) { return look % rarely == phase ? 0.1 : 0.0; };
                EXPECT_FALSE(found_after(gap, a_step, StopSearch::gets_going))
                    << "every " << rarely << " looks, one every " << seconds(gap) << " s";
            }
}

TEST(StopSearch, WhatWasToldAgainAndStandsStillHasFoundItsStopThoughItSeemsNotToPush)
{
    EXPECT_TRUE(found_after(10ms, [](int) { return 0.0; }, StopSearch::gets_going + 3 * StopSearch::stand_still));
}

} // namespace
} // namespace sinew::robot
