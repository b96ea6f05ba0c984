#include "apps/cli/chart.hpp"

#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

TEST(Chart, ARisingLineGoesFromTheLowerLeftToTheUpperRight)
{
    const std::vector<double> x{0, 1, 2, 3}, y{0, 1, 2, 3};
    EXPECT_EQ(chart(x, y, 2, 1), (std::vector<std::string>{"\xE2\xA3\xA0\xE2\xA0\x9E"}));
}

TEST(Chart, AConstantIsALineInTheMiddleAndNothingIsEmpty)
{
    const std::vector<double> x{0, 1, 2, 3}, y{5, 5, 5, 5};
    EXPECT_EQ(chart(x, y, 1, 1)[0], "\xE2\xA0\x92"); // one row of both columns
    const auto lines = chart({}, {}, 3, 2);
    EXPECT_EQ(lines, (std::vector<std::string>(2, "\xE2\xA0\x80\xE2\xA0\x80\xE2\xA0\x80")));
}

TEST(Chart, AJumpHasNoGap)
{
    const std::vector<double> x{0, 1}, y{0, 1};
    const auto lines = chart(x, y, 1, 3);
    EXPECT_EQ(lines[1], "\xE2\xA2\xB8"); // all four dots of the right column
}

} // namespace
} // namespace sinew::cli
