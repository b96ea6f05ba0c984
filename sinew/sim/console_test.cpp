#include "sinew/sim/console.hpp"

#include "sinew/sim/world_test_support.hpp"

namespace sinew::sim::test {
namespace {

struct ConsoleTest : testing::Test {
    void SetUp() override { world = *World::make(robot()); }
    std::string said(std::string_view line)
    {
        const auto answer = respond(*world, line);
        EXPECT_TRUE(answer) << to_sentence(answer.error());
        return answer.value_or("");
    }
    std::string complaint(std::string_view line)
    {
        const auto answer = respond(*world, line);
        EXPECT_FALSE(answer) << line;
        return answer ? "" : answer.error().detail;
    }
    std::unique_ptr<World> world;
};

TEST_F(ConsoleTest, AnEmptyLineShowsEveryDevice)
{
    const std::string all = said("");
    EXPECT_EQ(std::ranges::count(all, '\n'), 7);
    EXPECT_NE(all.find("knee "), std::string::npos);
    EXPECT_EQ(std::ranges::count(said("look knee hip"), '\n'), 3);
}

TEST_F(ConsoleTest, AFaultIsShownUntilItIsMended)
{
    EXPECT_EQ(said("fault elbow stuck-gear"), "");
    world->advance(TimePoint{} + 5ms);
    EXPECT_NE(said("look elbow").find("stuck-gear"), std::string::npos);
    EXPECT_EQ(said("mend elbow"), "1 fault taken back\n");
    EXPECT_EQ(said("look elbow").find("stuck-gear"), std::string::npos);
}

TEST_F(ConsoleTest, AFaultOfABusIsShownAtItsJoints)
{
    EXPECT_EQ(said("fault left power-cut"), "");
    world->advance(TimePoint{} + 50ms);
    EXPECT_NE(said("look elbow").find("off"), std::string::npos);
    EXPECT_NE(said("look elbow").find("power-cut"), std::string::npos);
    EXPECT_EQ(said("look knee").find("power-cut"), std::string::npos);
}

TEST_F(ConsoleTest, WhatItDoesNotKnowChangesNothing)
{
    EXPECT_NE(complaint("fualt elbow unplug").find("did you mean fault?"), std::string::npos);
    EXPECT_NE(complaint("look elbov").find("did you mean elbow?"), std::string::npos);
    EXPECT_NE(complaint("mend elbov").find("did you mean elbow?"), std::string::npos);
    EXPECT_NE(complaint("mend").find("mend what?"), std::string::npos);
    EXPECT_NE(complaint("fault elbow").find("TARGET KIND"), std::string::npos);
    EXPECT_TRUE(world->faults_of("elbow").empty());
}

} // namespace
} // namespace sinew::sim::test
