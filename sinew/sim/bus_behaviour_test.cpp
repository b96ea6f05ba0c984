#include "sinew/sim/world.hpp"
#include "sinew/sim/world_test_support.hpp"
#include "tests/support/covers.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sinew::sim::test {
namespace {

using ::sinew::test::covers;

struct Listener final : SerialHost {
    std::uint32_t bit_rate() const override { return 1'500'000; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint) override
    {
        heard.insert(heard.end(), bytes.begin(), bytes.end());
    }
    Bytes heard;
};

/// What comes back when the host asks a second device while the first one answers.
Bytes answers_to_two_at_once(std::string_view bus_options)
{
    const auto file =
        config::parse_robot_file(std::string(robot_text) + "[bus.left.sim]\n" + std::string(bus_options), "r.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    const auto world = World::make(*file);
    EXPECT_TRUE(world) << to_sentence(world.error());
    WorldBus& bus = **(*world)->find_bus("left");
    auto& wire = std::get<SerialWire>(bus.wire);
    Listener listener;
    wire.connect(&listener);
    wire.host_sends(sam_status_0, bus.bit_rate, (*world)->now());
    const TimePoint answers = (*world)->now() + 40 * std::chrono::seconds{1} / 1'500'000 +
                              bus.family->response_time.typical + std::chrono::microseconds{2};
    (*world)->advance(answers);
    wire.host_sends(sam_status_3, bus.bit_rate, answers);
    (*world)->advance(answers + 10ms);
    wire.connect(nullptr);
    return listener.heard;
}

TEST(SamBus, OfTwoLinesHearsAnswersWhileTheHostTalksAndOfOnePairDoesNot)
{
    covers("A.1 8");
    const Bytes both{0, 127, 0, 127}; // no load, in the middle; of either device
    EXPECT_EQ(answers_to_two_at_once(""), both);
    EXPECT_NE(answers_to_two_at_once("half_duplex = true\n"), both);
}

TEST(SamBus, OfOnePairIsForTheEncoderModelsOnly)
{
    covers("A.1 8");
    std::string text(robot_text);
    text.replace(text.find("SAM-210EO200"), 12, "SAM-20");
    const auto file = config::parse_robot_file(text + "[bus.left.sim]\nhalf_duplex = true\n", "r.toml");
    ASSERT_TRUE(file);
    const auto world = World::make(*file);
    ASSERT_FALSE(world);
    EXPECT_EQ(to_sentence(world.error()).find("r.toml:16:"), 0U) << to_sentence(world.error());
    EXPECT_NE(to_sentence(world.error()).find("SAM-20 has no RS-485"), std::string::npos);
}

TEST(SamBus, HasNoDuplexWhereItIsCan)
{
    const auto file =
        config::parse_robot_file(std::string(robot_text) + "[bus.legs.sim]\ncollision = \"and\"\n", "r.toml");
    ASSERT_TRUE(file);
    const auto world = World::make(*file);
    ASSERT_FALSE(world);
    EXPECT_NE(to_sentence(world.error()).find("this one is CAN"), std::string::npos);
}

struct CanListener final : CanHost {
    std::uint32_t bit_rate() const override { return 1'000'000; }
    void on_frame(const wire::Frame& frame, TimePoint) override { heard.push_back(frame.can_id); }
    std::vector<std::uint32_t> heard;
};

TEST(RmdBus, AnswersTheMultiMotorFrameInTheOrderOfIds)
{
    covers("C 16");
    std::string text = "version = 1\n[bus.legs]\nfamily = \"rmd\"\n";
    for (const int id : {3, 1, 5, 4, 2})
        text += fmt::format("[joint.j{}]\nbus = \"legs\"\nid = {}\nmodel = \"MG\"\n", id, id);
    const auto file = config::parse_robot_file(text, "r.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    const auto world = World::make(*file);
    ASSERT_TRUE(world) << to_sentence(world.error());
    auto& wire = std::get<CanWire>((*world)->buses().front().wire);
    CanListener listener;
    wire.connect(&listener);
    wire.host_sends({.can_id = 0x280, .size = 8}, 1'000'000, (*world)->now());
    (*world)->advance((*world)->now() + 10ms);
    wire.connect(nullptr);
    EXPECT_EQ(listener.heard, (std::vector<std::uint32_t>{0x141, 0x142, 0x143, 0x144}));
}

} // namespace
} // namespace sinew::sim::test
