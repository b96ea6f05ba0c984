#include "apps/cli/moving.hpp"

#include <csignal>
#include <filesystem>
#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

Words words_for(const std::string& bus, const std::string& family, const std::string& id)
{
    Words words;
    const auto demo =
        std::filesystem::weakly_canonical(std::filesystem::path{__FILE__}.parent_path() / "../../robots/demo.toml");
    words.add("TARGET", "sim:" + demo.string() + "#" + bus);
    words.add("--family", family);
    words.add("--id", id);
    if (family == "rmd")
        words.add("--profile", "rmd-2.35");
    return words;
}

class MovingTest : public testing::TestWithParam<std::tuple<const char*, const char*, const char*>>
{
};

/// A signal with every frame that goes out, as somebody sends them who holds Ctrl-C down.
TEST_P(MovingTest, ASecondInterruptDoesNotCancelTheClosingHold)
{
    const auto [bus, family, id] = GetParam();
    Session session;
    auto device = target(words_for(bus, family, id));
    ASSERT_TRUE(device) << to_sentence(device.error());
    auto driven = drive_and_read(session, std::move(*device));
    ASSERT_TRUE(driven) << to_sentence(driven.error());
    const auto turn = driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 0.3}, driven->state);
    ASSERT_TRUE(turn);
    ASSERT_TRUE(carry_out(*driven, *turn));
    wait_until(session, session.clock().now() + std::chrono::seconds(1));

    int frames = 0;
    driven->bus->set_tap([&](const bus::Tapped&) {
        ++frames;
        (void)std::raise(SIGINT);
    });
    (void)std::raise(SIGINT);
    const auto stopped = stop_here(session, *driven);
    EXPECT_TRUE(stopped) << to_sentence(stopped.error());
    EXPECT_GT(frames, 1);
    driven->bus->set_tap({});
    EXPECT_TRUE(interrupted());
    clear_interrupt();

    for (const auto time : {std::chrono::milliseconds(500), std::chrono::milliseconds(1000)}) {
        const double before = position_of(*driven);
        wait_until(session, session.clock().now() + time);
        ASSERT_TRUE(read_state(*driven, actuator::Depth::motion));
        if (time == std::chrono::milliseconds(1000)) {
            EXPECT_NEAR(position_of(*driven), before, 0.01);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Families, MovingTest,
                         testing::Values(std::tuple{"left", "sam", "3"}, std::tuple{"waist", "nuri", "3"},
                                         std::tuple{"legs", "rmd", "1"}),
                         [](const auto& one) { return std::string(std::get<1>(one.param)); });

} // namespace
} // namespace sinew::cli
