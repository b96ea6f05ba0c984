#include "apps/cli/moving.hpp"
#include "apps/cli/stopping.hpp"
#include "apps/cli/turning.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

/// One that is blocked at 30 deg on its way to 60.
class PressingTest : public testing::Test
{
protected:
    PressingTest()
    {
        path_ = testing::TempDir() + "sinew-pressing.toml";
        std::ofstream(path_) << "version = 1\n[bus.b]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"b\"\nid = 1\n"
                                "model = \"MG\"\nprofile = \"rmd-2.35\"\nvelocity_max_deg_s = 60\n"
                                "[joint.knee.plant]\nstop_max_deg = 30\n";
        words_.add("--json", "");
        Words of;
        of.add("TARGET", "knee");
        of.add("--robot", path_);
        of.add("--sim", "");
        device_ = *target(of);
    }
    ~PressingTest() override { std::filesystem::remove(path_); }

    double current_a(Driven& driven)
    {
        wait_until(session_, session_.clock().now() + 100ms);
        EXPECT_TRUE(read_state(driven, actuator::Depth::full));
        return driven.state.current_a.value_or(NAN);
    }

    std::string path_;
    Device device_;
    Session session_;
    Words words_;
};

TEST_F(PressingTest, AMoveThatIsBlockedPressesNoMoreWhenItHasEnded)
{
    auto driven = drive(session_, device_);
    ASSERT_TRUE(driven && set_up(*driven) && read_state(*driven, actuator::Depth::full));
    testing::internal::CaptureStdout();
    const auto moved = move_to(words_, session_, *driven, {.position_rad = 1.0});
    (void)testing::internal::GetCapturedStdout();
    ASSERT_FALSE(moved);
    EXPECT_NE(moved.error().detail.find("t is held at 30.00 deg"), std::string::npos) << moved.error().detail;
    EXPECT_NEAR(current_a(*driven), 0.0, 0.1);
}

TEST_F(PressingTest, WhatAnotherProgramLeftPressingPressesNoMoreWhenItIsStoppedAndHeld)
{
    auto driven = drive(session_, device_);
    ASSERT_TRUE(driven && set_up(*driven) && read_state(*driven, actuator::Depth::full));
    const auto push = driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 1.0}, {});
    ASSERT_TRUE(push && carry_out(*driven, *push));
    wait_until(session_, session_.clock().now() + 2s);
    ASSERT_GT(current_a(*driven), 7.0);
    std::vector<Stopping> all;
    all.emplace_back(session_, device_, true);
    all.front().tell();
    see_to_rest(session_, all);
    const auto outcome = all.front().outcome();
    ASSERT_TRUE(outcome) << to_sentence(outcome.error());
    EXPECT_EQ(outcome->says, "holds at 30.00 deg");
    EXPECT_NEAR(current_a(*driven), 0.0, 0.1);
}

} // namespace
} // namespace sinew::cli
