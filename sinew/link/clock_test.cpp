#include "sinew/link/clock.hpp"

#include "sinew/link/link_test_support.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <vector>

namespace sinew::link {
namespace {

using std::chrono::milliseconds;

class RealClockTest : public ::testing::Test
{
protected:
    void SetUp() override { ASSERT_EQ(::pipe(pipe_), 0); }
    void TearDown() override
    {
        ::close(pipe_[0]);
        ::close(pipe_[1]);
    }

    RealClock clock_;
    int pipe_[2]{};
};

TEST_F(RealClockTest, WaitsUntilTheDeadlineWhenNothingComes)
{
    const Handle handles[] = {{.fd = -1}, {.fd = pipe_[0]}};
    const TimePoint deadline = clock_.now() + milliseconds{3};
    // A signal may end one wait early; the deadline is what the loop is about.
    while (clock_.now() < deadline)
        clock_.wait(handles, deadline);
    EXPECT_GE(clock_.now(), deadline);
    EXPECT_LT(clock_.now(), deadline + test::patience);
}

TEST_F(RealClockTest, ReturnsAtOnceWhenSomethingIsThere)
{
    ASSERT_EQ(::write(pipe_[1], "x", 1), 1);
    const Handle handles[] = {{.fd = -1}, {.fd = pipe_[0]}};
    const TimePoint deadline = clock_.now() + test::patience;
    clock_.wait(handles, deadline);
    EXPECT_LT(clock_.now(), deadline);
}

TEST_F(RealClockTest, WakesForRoomToWriteOnlyWhenAsked)
{
    const Handle wants[] = {{.fd = pipe_[1], .wants_write = true}};
    const TimePoint far = clock_.now() + test::patience;
    clock_.wait(wants, far);
    EXPECT_LT(clock_.now(), far);

    const Handle does_not[] = {{.fd = pipe_[1]}};
    const TimePoint near = clock_.now() + milliseconds{3};
    while (clock_.now() < near)
        clock_.wait(does_not, near);
    EXPECT_GE(clock_.now(), near);
}

TEST_F(RealClockTest, OnlyLooksWhenTheDeadlineIsGone)
{
    const Handle handles[] = {{.fd = pipe_[0]}};
    const TimePoint before = clock_.now();
    clock_.wait(handles, before - std::chrono::hours{1});
    clock_.wait({}, TimePoint{});
    EXPECT_LT(clock_.now(), before + test::patience);
}

TEST_F(RealClockTest, TheLastOfVeryManyHandlesEndsTheWaitToo)
{
    std::vector<Handle> handles(500);
    handles.push_back({.fd = pipe_[0]});
    ASSERT_EQ(::write(pipe_[1], "x", 1), 1);
    const TimePoint deadline = clock_.now() + test::patience;
    clock_.wait(handles, deadline);
    EXPECT_LT(clock_.now(), deadline);
}

} // namespace
} // namespace sinew::link
