#include "apps/cli/moving.hpp"

#include "sinew/base/units.hpp"

#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <unistd.h>

namespace sinew::cli {
namespace {

std::string demo_path()
{
    return "robots/demo.toml"; // tests run in the folder of the sources
}

Words words_for(const std::string& bus, const std::string& family, const std::string& id)
{
    Words words;
    words.add("TARGET", "sim:" + demo_path() + "#" + bus);
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
    EXPECT_GE(frames, 1);
    driven->bus->set_tap({});
    EXPECT_TRUE(interrupted());
    clear_interrupt();

    for (const auto time : {std::chrono::milliseconds(500), std::chrono::milliseconds(1000)}) {
        const double before = position_of(*driven).value();
        wait_until(session, session.clock().now() + time);
        ASSERT_TRUE(read_state(*driven, actuator::Depth::motion));
        if (time == std::chrono::milliseconds(1000)) {
            EXPECT_NEAR(position_of(*driven).value(), before, 0.01);
        }
    }
}

/// As with another model than it should be, or by a wrong byte of an answer without a checksum.
TEST(Moving, AMoveFromWhereNoActuatorCanBeSendsNothing)
{
    Session session;
    auto device = target(words_for("left", "sam", "5"));
    ASSERT_TRUE(device) << to_sentence(device.error());
    auto driven = drive_and_read(session, std::move(*device));
    ASSERT_TRUE(driven) << to_sentence(driven.error());
    int frames = 0;
    driven->bus->set_tap([&](const bus::Tapped&) { ++frames; });
    for (const double position_deg : {1033.93, -1033.93}) {
        driven->state.position_rad = {units::rad(position_deg), session.clock().now()};
        const auto moved = move_to(Words{}, session, *driven, {.position_rad = 0.0});
        ASSERT_FALSE(moved);
        EXPECT_EQ(moved.error().code, Errc::out_of_range);
        EXPECT_NE(to_sentence(moved.error()).find("further than a SAM-20 reaches"), std::string::npos)
            << to_sentence(moved.error());
    }
    EXPECT_EQ(frames, 0);
}

/// Drops bytes on a bus of the demo robot from a time on.
class RobotFileWithLosses
{
public:
    explicit RobotFileWithLosses(int seed)
    {
        std::ifstream demo(demo_path());
        std::ofstream(path_) << std::string{std::istreambuf_iterator<char>{demo}, {}}
                             << fmt::format("\n[sim]\nseed = {}\n[[sim.fault]]\nbus = \"waist\"\nkind = "
                                            "\"drop-bytes\"\nprobability = 0.05\nat_s = 1.0\n",
                                            seed);
    }
    ~RobotFileWithLosses() { std::filesystem::remove(path_); }
    RobotFileWithLosses(const RobotFileWithLosses&) = delete;
    RobotFileWithLosses& operator=(const RobotFileWithLosses&) = delete;
    const std::string& path() const { return path_; }

private:
    std::string path_ = (std::filesystem::temp_directory_path() / fmt::format("losses-{}.toml", ::getpid())).string();
};

/// Nuri acknowledges nothing, so a hold that is lost on the wire looks like one that arrived.
TEST(Moving, AHoldThatWasLostOnTheWireIsToldAgain)
{
    int held = 0;
    for (int seed = 1; seed <= 40; ++seed) {
        const RobotFileWithLosses file(seed);
        Session session;
        Words words;
        words.add("TARGET", "waist_yaw");
        words.add("--robot", file.path());
        words.add("--sim", "");
        auto device = target(words);
        ASSERT_TRUE(device) << to_sentence(device.error());
        auto driven = drive_and_read(session, std::move(*device));
        ASSERT_TRUE(driven) << to_sentence(driven.error());
        const auto turn =
            driven->driver->plan({.mode = actuator::Mode::velocity, .velocity_rad_s = 0.3}, driven->state);
        ASSERT_TRUE(turn);
        ASSERT_TRUE(carry_out(*driven, *turn));
        wait_until(session, session.clock().now() + std::chrono::milliseconds(1000));

        (void)std::raise(SIGINT);
        const auto stopped = stop_here(session, *driven);
        clear_interrupt();
        if (!stopped)
            continue; // it says itself that nothing is known
        ++held;
        const auto rest = [&] {
            for (int again = 0; again < 10; ++again)
                if (read_state(*driven, actuator::Depth::motion))
                    return position_of(*driven).value();
            return std::numeric_limits<double>::quiet_NaN();
        };
        const double before = rest();
        wait_until(session, session.clock().now() + std::chrono::milliseconds(500));
        EXPECT_NEAR(rest(), before, 0.01) << "seed " << seed;
    }
    EXPECT_GT(held, 30);
}

INSTANTIATE_TEST_SUITE_P(Families, MovingTest,
                         testing::Values(std::tuple{"left", "sam", "3"}, std::tuple{"waist", "nuri", "3"},
                                         std::tuple{"legs", "rmd", "1"}),
                         [](const auto& one) { return std::string(std::get<1>(one.param)); });

} // namespace
} // namespace sinew::cli
