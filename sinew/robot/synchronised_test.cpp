#include "sinew/robot/synchronised.hpp"

#include "tests/support/allocations.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;

constexpr MotionLimits quick{.velocity_rad_s = 4.0, .acceleration_rad_s2 = 20.0, .jerk_rad_s3 = 200.0};
constexpr MotionLimits slow{.velocity_rad_s = 0.5, .acceleration_rad_s2 = 1.0, .jerk_rad_s3 = 10.0};

TEST(Synchronised, TheSlowestJointSetsTheTimeAndAllArriveWithIt)
{
    const std::array joints{JointMotion{.from_rad = 0, .target_rad = 1, .limits = quick},
                            JointMotion{.from_rad = 1, .target_rad = -1, .limits = slow},
                            JointMotion{.from_rad = 2, .target_rad = 2, .limits = quick}};
    Synchronised motion;
    ASSERT_TRUE(motion.plan(joints));
    EXPECT_EQ(motion.duration(), Trajectory::plan(1, 0, -1, slow)->duration());
    EXPECT_EQ(motion.size(), 3U);
    for (std::size_t i = 0; i < joints.size(); ++i) {
        EXPECT_EQ(motion.at(i, motion.duration()).position_rad, joints[i].target_rad);
        const bool moves = joints[i].from_rad != joints[i].target_rad;
        // Shortly before the end none has arrived yet.
        EXPECT_EQ(motion.at(i, motion.duration() - 10ms).position_rad == joints[i].target_rad, !moves);
    }
}

TEST(Synchronised, ADurationThatIsAskedForIsKept)
{
    const std::array joints{JointMotion{.target_rad = 1, .limits = quick},
                            JointMotion{.target_rad = 1, .limits = slow}};
    Synchronised motion;
    ASSERT_TRUE(motion.plan(joints, 7s));
    EXPECT_EQ(motion.duration(), 7s);
    EXPECT_NEAR(motion.at(0, 3500ms).position_rad, 0.5, 1e-9);
    EXPECT_NEAR(motion.at(1, 3500ms).position_rad, 0.5, 1e-9);
}

TEST(Synchronised, ADurationThatIsTooShortNamesTheJointAndKeepsTheMotionBefore)
{
    const std::array joints{JointMotion{.target_rad = 1, .limits = quick},
                            JointMotion{.target_rad = 1, .limits = slow}};
    Synchronised motion;
    ASSERT_TRUE(motion.plan(joints, 7s));
    const auto planned = motion.plan(joints, 1s);
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().code, Errc::out_of_range);
    EXPECT_EQ(planned.error().value, 1);
    EXPECT_EQ(motion.duration(), 7s);
    EXPECT_EQ(motion.size(), 2U);
}

TEST(Synchronised, AJointThatCannotWaitSoLongDelaysTheOthers)
{
    // The moving one arrives after 0.75 s or after it has come to rest first; the other wants a moment between the two.
    constexpr MotionLimits limits{.velocity_rad_s = 2.0, .acceleration_rad_s2 = 4.0, .jerk_rad_s3 = 16.0};
    const JointMotion moving{.from_velocity_rad_s = 2.0, .target_rad = 0.751, .limits = limits};
    const auto alone = Trajectory::plan(0, 2.0, 0.751, limits);
    const Duration between = alone->duration() + 10ms;
    const double way = 2.0 * std::pow(seconds(between) / 4.0, 3.0) * limits.jerk_rad_s3;
    const std::array joints{JointMotion{.target_rad = way, .limits = limits}, moving};
    Synchronised motion;
    ASSERT_TRUE(motion.plan(std::span(joints).first(1)));
    ASSERT_NEAR(seconds(motion.duration()), seconds(between), 1e-6);
    ASSERT_TRUE(motion.plan(joints));
    EXPECT_EQ(motion.duration(), alone->reachable(between));
    EXPECT_EQ(motion.at(0, motion.duration()).position_rad, way);
    EXPECT_EQ(motion.at(1, motion.duration()).position_rad, 0.751);
}

TEST(Synchronised, AJointThatMakesNoSenseIsNamed)
{
    const std::array joints{JointMotion{.target_rad = 1, .limits = quick}, JointMotion{.target_rad = 1}};
    Synchronised motion;
    const auto planned = motion.plan(joints);
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().code, Errc::bad_argument);
    EXPECT_EQ(planned.error().value, 1);
    EXPECT_TRUE(motion.plan({}));
    EXPECT_EQ(motion.duration(), 0ns);
}

TEST(Synchronised, OnceReservedNeitherPlanNorSampleAsksTheHeap)
{
    const std::array joints{JointMotion{.target_rad = 1, .limits = quick},
                            JointMotion{.target_rad = 1, .limits = slow}};
    Synchronised motion;
    motion.reserve(2);
    const auto before = support::allocations();
    ASSERT_TRUE(motion.plan(joints));
    double sum = 0.0;
    for (Duration t{}; t < motion.duration(); t += 1ms)
        sum += motion.at(0, t).position_rad + motion.at(1, t).position_rad;
    ASSERT_TRUE(motion.plan(joints, 8s));
    EXPECT_EQ(support::allocations(), before);
    EXPECT_GT(sum, 0.0);
}

} // namespace
} // namespace sinew::robot
