#include "apps/cli/dead_man.hpp"

#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view right = "\033[C";
constexpr std::string_view left = "\033[D";
constexpr TimePoint begin = TimePoint{} + 10s;

TEST(DeadMan, MovesOnlyWhileAKeyRepeats)
{
    DeadMan man;
    EXPECT_EQ(man.direction(begin), 0);
    man.press(right, begin);
    EXPECT_EQ(man.direction(begin + 100ms), 1);
    EXPECT_EQ(man.direction(begin + 120ms), 0) << "one press is a nudge";
    TimePoint now = begin + 500ms;
    for (int i = 0; i < 20; ++i, now += 30ms) {
        man.press(right, now);
        EXPECT_EQ(man.direction(now + 29ms), 1);
    }
    const TimePoint last = now - 30ms;
    EXPECT_EQ(man.direction(last + 199ms), 1);
    EXPECT_EQ(man.direction(last + 200ms), 0) << "let go";
}

TEST(DeadMan, TurnsRoundAtTheOtherKey)
{
    DeadMan man;
    man.press(right, begin);
    man.press(right, begin + 50ms);
    man.press(left, begin + 100ms);
    EXPECT_EQ(man.direction(begin + 101ms), -1);
    EXPECT_EQ(man.direction(begin + 221ms), 0) << "the other key was pressed once";
}

TEST(DeadMan, StopsAtSpaceAndAtKeysThatMeanNothing)
{
    for (const std::string_view key : {" ", "x", "\r", "\033[F"}) {
        DeadMan man;
        man.press(right, begin);
        man.press(right, begin + 30ms);
        EXPECT_EQ(man.press(key, begin + 60ms), DeadMan::Wish::stop);
        EXPECT_EQ(man.direction(begin + 60ms), 0);
    }
}

TEST(DeadMan, KnowsLettersAndWishes)
{
    DeadMan man;
    man.press("l", begin);
    EXPECT_EQ(man.direction(begin), 1);
    man.press("h", begin);
    EXPECT_EQ(man.direction(begin), -1);
    EXPECT_EQ(man.press("+", begin), DeadMan::Wish::faster);
    EXPECT_EQ(man.press("-", begin), DeadMan::Wish::slower);
    EXPECT_EQ(man.press("q", begin), DeadMan::Wish::quit);
    EXPECT_EQ(man.press("q ", begin), DeadMan::Wish::quit);
    EXPECT_EQ(man.press("\033", begin), DeadMan::Wish::quit);
    EXPECT_EQ(man.press("", begin), DeadMan::Wish::none);
}

} // namespace
} // namespace sinew::cli
