#include "apps/cli/jog_aim.hpp"

#include "sinew/base/units.hpp"

#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

const config::Joint joint{.position_min_rad = -1.0, .position_max_rad = 1.0, .velocity_max_rad_s = 1.0};
constexpr double step = 0.01, ahead = 0.1;

TEST(JogAim, FromBeyondALimitTheKeyThatPointsOutwardsDoesNotDriveItInwards)
{
    for (const int out : {1, -1}) {
        JogAim aim(&joint);
        EXPECT_FALSE(aim.step(out * 1.7, out, step, ahead));
        double here = out * 1.7;
        for (int i = 1; i <= 200; ++i) {
            const auto target = aim.step(here, -out, step, ahead);
            ASSERT_TRUE(target);
            EXPECT_NEAR(*target, out * (1.7 - i * step), 1e-9) << "at the speed of the keys, within the limit too";
            here = *target;
        }
    }
}

TEST(JogAim, GoesNoFurtherThanALimitAndBackFromThere)
{
    JogAim aim(&joint);
    EXPECT_EQ(aim.step(0.995, 1, step, ahead), 1.0);
    EXPECT_EQ(aim.step(1.0, 1, step, ahead), 1.0);
    EXPECT_NEAR(*aim.step(1.0, -1, step, ahead), 0.99, 1e-9);
}

TEST(JogAim, BeginsAgainWhereTheJointIs)
{
    JogAim aim(&joint);
    (void)aim.step(0.0, 1, step, ahead);
    aim.forget();
    EXPECT_NEAR(*aim.step(0.5, 1, step, ahead), 0.51, 1e-9);
}

TEST(JogAim, DoesNotLeadOnWhatDoesNotFollow)
{
    JogAim aim(&joint);
    for (int i = 0; i < 50; ++i)
        EXPECT_LE(*aim.step(0.0, 1, step, ahead), ahead);
}

TEST(JogAim, IsNoFasterThanTheJointMayTurn)
{
    EXPECT_EQ(JogAim(&joint).faster_rad_s(0.9), 1.0);
    EXPECT_EQ(JogAim(&joint).faster_rad_s(0.5), 0.75);
    EXPECT_EQ(JogAim(nullptr).faster_rad_s(4.0), 6.0);
}

} // namespace
} // namespace sinew::cli
