#include "tests/robot/lossy_can.hpp"

#include <gtest/gtest.h>

/// Motors that answer, but no longer say where they are.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t read_multi_turn_angle = 0x92;

std::string knee(std::string_view safety, std::string_view limits)
{
    return fmt::format("version = 1\n[safety]\n{}\n[bus.r]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"r\"\nid = 1\n"
                       "model = \"MG\"\nprofile = \"rmd-2.35\"\n{}\n",
                       safety, limits);
}

Losses no_answer_to(std::uint8_t question)
{
    Losses losses;
    losses.of_heard = [question](const wire::Frame& frame) { return frame.data[0] == question; };
    return losses;
}

constexpr std::string_view limits = "position_min_deg = -90\nposition_max_deg = 90";

TEST(Unplaced, AJointWhosePositionAloneGoesMissingIsStopped)
{
    for (const Command& command :
         {Command{.mode = Mode::hold}, Command{.mode = Mode::velocity, .velocity_rad_s = 0.1}}) {
        LossyRobot one(knee("silence_max_s = 0.2", limits));
        ASSERT_EQ(said(one.run(command, 100ms)), "");
        one.losses = no_answer_to(read_multi_turn_angle);
        const auto ended = said(one.run(command, 2s));
        EXPECT_NE(ended.find("knee: it answers, but has not told its position for 0.2"), std::string::npos) << ended;
        EXPECT_FALSE(one.robot->enabled());
    }
}

TEST(Unplaced, AJointThatIsFreeOrHasNoLimitsMayKeepItsPlaceToItself)
{
    LossyRobot free(knee("silence_max_s = 0.2", limits));
    ASSERT_EQ(said(free.run({.mode = Mode::release}, 100ms)), "");
    free.losses = no_answer_to(read_multi_turn_angle);
    EXPECT_EQ(said(free.run({.mode = Mode::release}, 2s)), "");
    EXPECT_EQ(free.knee().overruled(), 0U);

    LossyRobot wheel(knee("silence_max_s = 0.2", ""));
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = 1.0};
    ASSERT_EQ(said(wheel.run(turn, 100ms)), "");
    wheel.losses = no_answer_to(read_multi_turn_angle);
    EXPECT_EQ(said(wheel.run(turn, 2s)), "");
    EXPECT_EQ(wheel.knee().overruled(), 0U);
}

} // namespace
} // namespace sinew::robot::test
