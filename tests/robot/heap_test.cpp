#include "tests/robot/rig.hpp"
#include "tests/support/allocations.hpp"

#include <gtest/gtest.h>

namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Heap, ACycleOfSixteenJointsAsksForNothing)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.run(3s)) << "every kind of reading has had its turn";
    double phase = 0.0;
    int refused = 0;
    const auto step = [&] {
        phase += 0.01;
        for (Joint& joint : rig.robot->joints()) {
            const double sense = joint.name().ends_with("hip") ? -1.0 : 1.0;
            refused +=
                joint.set({.mode = Mode::position, .position_rad = sense * 0.1 * (1.0 - std::cos(phase))}) ? 0 : 1;
        }
        (void)rig.robot->cycle();
    };
    const auto before = support::allocations();
    for (int i = 0; i < 500; ++i)
        step();
    EXPECT_EQ(support::allocations() - before, 0U);
    EXPECT_EQ(refused, 0);
    EXPECT_TRUE(rig.robot->incidents().empty());
}

/// It looks first, and what a stop would send is for a while not to hold but to brake.
TEST(Heap, ACycleAfterAPauseAsksForNothing)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.run(3s));
    for (int i = 0; i < 10; ++i) {
        ASSERT_EQ(said(rig.robot->cycle()), "");
        rig.simulator->clock().wait({}, rig.now() + 300ms);
        const auto before = support::allocations();
        EXPECT_EQ(said(rig.robot->cycle()), "");
        EXPECT_EQ(support::allocations() - before, 0U);
    }
}

TEST(Heap, ALoopOfTheLibraryAsksForNothing)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_TRUE(rig.run(3s));
    std::uint64_t before = 0, after = 0;
    int calls = 0;
    const std::function<void(Robot&)> each = [&](Robot&) {
        if (++calls == 10)
            before = support::allocations();
        after = support::allocations();
    };
    ASSERT_TRUE(rig.robot->run(5ms, each, rig.now() + 2s));
    EXPECT_EQ(calls, 400);
    EXPECT_EQ(after - before, 0U);
}

} // namespace
} // namespace sinew::robot::test
