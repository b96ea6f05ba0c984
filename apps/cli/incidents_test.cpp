#include "apps/cli/robot_session.hpp"
#include "apps/cli/verb.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

std::string told(RobotSession& session)
{
    testing::internal::CaptureStderr();
    session.tell_incidents();
    return testing::internal::GetCapturedStderr();
}

TEST(RobotSession, SaysHowManyIncidentsAreNoLongerKnownAndTellsTheRestOnce)
{
    Words words;
    words.add("--robot", "robots/demo.toml"); // tests run in the folder of the sources
    words.add("--sim", "");
    auto file = robot_file(words);
    ASSERT_TRUE(file) << to_sentence(file.error());
    auto session = RobotSession::open(words, std::move(*file));
    ASSERT_TRUE(session) << to_sentence(session.error());
    auto& robot = (*session)->robot();
    ASSERT_TRUE(robot.enable());
    while (robot.incidents_dropped() == 0)
        ASSERT_TRUE(robot.home()); // joints that cannot know their turn say so every time
    const auto dropped = robot.incidents_dropped();
    const auto first = told(**session);
    EXPECT_TRUE(first.starts_with(fmt::format("sinew: {} more that happened before are no longer known\n", dropped)))
        << first.substr(0, 200);
    EXPECT_EQ(std::ranges::count(first, '\n'), 1 + std::ssize(robot.incidents()));
    EXPECT_EQ(told(**session), "");
    ASSERT_TRUE(robot.home());
    const auto more = told(**session);
    EXPECT_EQ(std::ranges::count(more, '\n'), static_cast<std::ptrdiff_t>(robot.incidents_dropped() - dropped));
    EXPECT_EQ(more.find("no longer known"), std::string::npos) << more;
}

} // namespace
} // namespace sinew::cli
