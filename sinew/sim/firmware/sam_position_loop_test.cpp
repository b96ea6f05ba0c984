#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/sam_device.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::covers;

/// A move of 90 degrees up against a hanging load.
struct Response {
    double overshoot_rad = 0.0; ///< past the target
    int crossings = 0;          ///< of where it comes to rest
    double error_rad = 0.0;     ///< in the end
};

Response lift(int p, int i, int d)
{
    sam::Spec spec{.model = sam::find_model("SAM-20"), .profile = sam::profiles()[0], .id = 5};
    spec.device.response_level = 1;
    PlantParameters plant = plant_of(spec);
    plant.gravity_torque_nm = 0.3 * spec.model->ratings.max_torque_nm;
    Bench<SamDevice> bench(spec, plant);
    bench.ask(sam::SetRuntimePdGain{static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(d)});
    bench.ask(sam::SetRuntimeIGain{static_cast<std::uint8_t>(i)});
    const double target = spec.model->standard.rad(3131); // 90 degrees
    bench.ask(sam::PositionControl{.target_position = 3131});

    Response out;
    std::array<double, 8000> way{};
    for (double& position : way) {
        bench.run(1ms);
        position = bench.device.look().position_rad;
        out.overshoot_rad = std::max(out.overshoot_rad, position - target);
    }
    for (std::size_t k = 1; k < way.size(); ++k)
        out.crossings += (way[k] - way.back()) * (way[k - 1] - way.back()) < 0.0;
    out.error_rad = target - way.back();
    return out;
}

TEST(SamPositionLoop, SwingsWithPDampsWithDAndTakesTheErrorOfALoadWithI)
{
    covers("A.3 5");
    const Response p = lift(100, 0, 0);
    EXPECT_GT(p.overshoot_rad, 0.05);
    EXPECT_GE(p.crossings, 3);
    EXPECT_GT(p.error_rad, 0.02) << "0.3 of the duty takes 0.04 rad of a P of 7.6 duty/rad";

    const Response pd = lift(100, 0, 100);
    EXPECT_LE(pd.overshoot_rad, 0.0);
    EXPECT_LE(pd.crossings, 1);
    EXPECT_GT(pd.error_rad, 0.02);

    const Response pid = lift(100, 10, 100);
    EXPECT_LT(std::abs(pid.error_rad), units::rad(0.1));
    EXPECT_LT(pid.overshoot_rad, 0.2);
}

TEST(SamPositionLoop, GivesLessWayToALoadTheMorePItHas)
{
    covers("A.3 5");
    EXPECT_GT(lift(50, 0, 100).error_rad, 1.5 * lift(100, 0, 100).error_rad);
}

TEST(SamPositionLoop, NeverPutsOutMoreThanItsLimit)
{
    SamPositionLoop loop;
    loop.begin(0.0);
    double most = 0.0;
    for (int k = 0; k < 5000; ++k)
        most = std::max(most, loop.duty(1.0, 0.0, 0.0, {.p = 1, .i = 100, .d = 0}, 0.25));
    EXPECT_DOUBLE_EQ(most, 0.25);
    // What I has gathered is no more than that either, so it comes back at once.
    EXPECT_LT(loop.duty(-3.0, 0.0, 0.0, {.p = 1, .i = 100, .d = 0}, 0.25), 0.0 + 0.25);
    for (int k = 0; k < 400; ++k)
        most = loop.duty(-1.0, 0.0, 0.0, {.p = 1, .i = 100, .d = 0}, 0.25);
    EXPECT_DOUBLE_EQ(most, -0.25);
}

} // namespace
} // namespace sinew::sim
