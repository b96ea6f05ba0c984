#include "apps/cli/moving.hpp"
#include "apps/cli/stopping.hpp"
#include "apps/cli/turning.hpp"

#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

using namespace std::chrono_literals;

/// One that is blocked at 30 deg on its way to 60.
struct PressingKnee {
    explicit PressingKnee(std::string_view more = "", std::string_view profile = "rmd-2.35")
    {
        std::ofstream(path) << "version = 1\n[bus.b]\nfamily = \"rmd\"\n[joint.knee]\nbus = \"b\"\nid = 1\n"
                               "model = \"MG\"\nprofile = \""
                            << profile
                            << "\"\nvelocity_max_deg_s = 60\n"
                               "[joint.knee.plant]\nstop_max_deg = 30\n"
                            << more;
        words.add("--json", "");
        Words of;
        of.add("TARGET", "knee");
        of.add("--robot", path);
        of.add("--sim", "");
        device = *target(of);
        auto opened = drive(session, device);
        EXPECT_TRUE(opened) << to_sentence(opened.error());
        EXPECT_TRUE(set_up(*opened) && read_state(*opened, actuator::Depth::full));
        driven.emplace(std::move(*opened));
    }
    ~PressingKnee() { std::filesystem::remove(path); }

    double current_a()
    {
        wait_until(session, session.clock().now() + 100ms);
        EXPECT_TRUE(read_state(*driven, actuator::Depth::full));
        return driven->state.current_a.value_or(NAN);
    }
    void push()
    {
        const auto push = driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 1.0}, {});
        ASSERT_TRUE(push && carry_out(*driven, *push));
        wait_until(session, session.clock().now() + 2s);
        ASSERT_GT(current_a(), 7.0);
    }

    std::string path = testing::TempDir() + "sinew-pressing.toml";
    Device device;
    Session session;
    Words words;
    std::optional<Driven> driven;
};

TEST(Pressing, AMoveThatIsBlockedPressesNoMoreWhenItHasEnded)
{
    PressingKnee knee;
    testing::internal::CaptureStdout();
    const auto moved = move_to(knee.words, knee.session, *knee.driven, {.position_rad = 1.0});
    (void)testing::internal::GetCapturedStdout();
    ASSERT_FALSE(moved);
    EXPECT_NE(moved.error().detail.find("t is held at 30.00 deg"), std::string::npos) << moved.error().detail;
    EXPECT_NEAR(knee.current_a(), 0.0, 0.1);
}

/// As `stop --hold` does it.
std::expected<Told, Error> stopped_and_held(PressingKnee& knee)
{
    std::vector<Stopping> all;
    all.emplace_back(knee.session, knee.device, true);
    all.front().tell();
    see_to_rest(knee.session, all);
    return all.front().outcome();
}

TEST(Pressing, WhatAnotherProgramLeftPressingPressesNoMoreWhenItIsStoppedAndHeld)
{
    PressingKnee knee;
    knee.push();
    const auto outcome = stopped_and_held(knee);
    ASSERT_TRUE(outcome) << to_sentence(outcome.error());
    EXPECT_EQ(outcome->says, "holds at 30.00 deg");
    EXPECT_NEAR(knee.current_a(), 0.0, 0.1);
}

/// Its reading was cut short, such as by the Ctrl-C that asks for the stop.
TEST(Pressing, WhatIsStoppedWhileNobodyKnowsHowFastItIsPressesNoMore)
{
    PressingKnee knee;
    knee.push();
    knee.driven->state = {};
    ASSERT_TRUE(come_to_rest(knee.session, *knee.driven));
    EXPECT_NEAR(knee.current_a(), 0.0, 0.1);
}

/// Switched off it answers all the same, and does nothing.
TEST(Pressing, AnLkMotorThatIsOffIsRunBeforeItIsSaidToHold)
{
    PressingKnee knee("", "lk-2.35");
    const auto off = knee.driven->driver->plan({.mode = actuator::Mode::release}, {});
    ASSERT_TRUE(off && carry_out(*knee.driven, *off));
    const auto outcome = stopped_and_held(knee);
    ASSERT_TRUE(outcome) << to_sentence(outcome.error());
    (void)knee.current_a();
    EXPECT_EQ(knee.driven->state.enabled.optional(), true);
}

/// Frames are lost at random while it is stopped: whatever is said to hold presses no more.
TEST(Pressing, WhatIsSaidToHoldOnABusThatLosesFramesWasLetGo)
{
    int held = 0, may_press = 0;
    for (int seed = 1; seed <= 40; ++seed) {
        PressingKnee knee(fmt::format("[sim]\nseed = {}\n[[sim.fault]]\nkind = \"drop-bytes\"\nbus = \"b\"\n"
                                      "probability = 0.3\nat_s = 2.2\nfor_s = 3\n",
                                      seed));
        knee.push();
        const auto rest = come_to_rest(knee.session, *knee.driven);
        wait_until(knee.session, knee.session.clock().now() + 4s);
        if (rest) {
            ++held;
            EXPECT_NEAR(knee.current_a(), 0.0, 0.1) << seed;
        } else {
            may_press += rest.error().detail.find("may press on") != std::string::npos ? 1 : 0;
        }
    }
    EXPECT_GT(held, 0);
    EXPECT_GT(may_press, 0);
}

} // namespace
} // namespace sinew::cli
