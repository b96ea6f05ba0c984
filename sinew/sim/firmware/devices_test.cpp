#include "sinew/family/families.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/devices.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "tests/support/allocations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

TEST(Devices, AllocateNothingWhileTheyHearAndMove)
{
    for (const Family* family : families()) {
        const auto spec = make_spec(*family, family->name == "sam" ? "SAM-160" : "", "", 1);
        ASSERT_TRUE(spec);
        std::vector<wire::Frame> frames;
        for (const auto* message : line_of(*spec).messages) {
            if (!message->request.exists())
                continue;
            const auto values = sample_values(*message, options_of(*spec));
            const auto frame = wire::encode(*message, wire::Direction::request, 1, values, options_of(*spec));
            ASSERT_TRUE(frame) << message->name();
            frames.push_back(*frame);
        }
        frames.push_back(frames.front());
        frames.back().data[3] ^= 0x55; // broken on its way

        std::size_t answers = 0;
        for (const wire::Frame& frame : frames) {
            const auto device = make_device(*spec, plant_of(*spec));
            device->run(supply_v(*spec));
            const auto before = support::allocations();
            answers += device->hear(frame, TimePoint{}).has_value();
            for (int i = 0; i < 20; ++i)
                device->run(supply_v(*spec));
            EXPECT_EQ(support::allocations(), before) << family->name;
        }
        EXPECT_GT(answers, 9U) << family->name;
    }
}

TEST(Devices, AreMadeFromWhatARobotFileMeans)
{
    for (const Family* family : families()) {
        const auto spec = make_spec(*family, family->name == "sam" ? "SAM-20" : "", "", 7);
        ASSERT_TRUE(spec);
        const auto device = make_device(*spec, plant_of(*spec));
        EXPECT_EQ(device->id(), 7);
        EXPECT_EQ(device->bit_rate(), 0U) << "without power";
        device->run(supply_v(*spec));
        EXPECT_EQ(device->bit_rate(), family->default_bit_rate);
        EXPECT_EQ(&device->protocol(), family->protocol);
    }
}

// ---- what they keep without power ----

/// What a device keeps, as the joint of a flash file.
config::FlashFile flash_of(const Device& device, std::string_view family)
{
    std::string text = fmt::format("version = 1\n[joint.elbow]\nfamily = \"{}\"\n", family);
    for (const KeptValue& kept : device.kept())
        text += fmt::format("{} = {}\n", kept.key, kept.value);
    const auto file = config::parse_flash_file(text, "flash.toml");
    EXPECT_TRUE(file) << to_sentence(file.error());
    return *file;
}

bool same(const std::vector<KeptValue>& one, const std::vector<KeptValue>& other)
{
    return std::ranges::equal(one, other,
                              [](const auto& a, const auto& b) { return a.key == b.key && a.value == b.value; });
}

TEST(Devices, GiveWhatTheyKeepToAnotherDeviceWhichKeepsItThroughAPowerCut)
{
    for (const Family* family : families()) {
        const auto spec = make_spec(*family, family->name == "sam" ? "SAM-160" : "", "", 1);
        const auto device = make_device(*spec, plant_of(*spec));
        device->run(supply_v(*spec));
        const auto delivered = device->kept();
        for (const auto* message : line_of(*spec).messages) {
            if (message->info.access != wire::Access::flash || message->name().find("reset") != std::string_view::npos)
                continue;
            const auto values = sample_values(*message, options_of(*spec));
            const auto frame =
                wire::encode(*message, wire::Direction::request, device->id(), values, options_of(*spec));
            device->hear(*frame, TimePoint{});
            device->answered(TimePoint{});
        }
        EXPECT_GE(device->flash_writes(), 3U) << family->name;
        EXPECT_FALSE(same(device->kept(), delivered)) << family->name;

        const auto other = make_device(*spec, plant_of(*spec));
        other->run(supply_v(*spec));
        const auto flash = flash_of(*device, family->name);
        const auto restored = other->restore(flash, flash.joints.front());
        ASSERT_TRUE(restored) << to_sentence(restored.error());
        EXPECT_TRUE(same(other->kept(), device->kept())) << family->name;
        EXPECT_EQ(other->id(), device->id()) << family->name;
        EXPECT_EQ(other->bit_rate(), device->bit_rate()) << family->name;
        other->power_cycle();
        EXPECT_TRUE(same(other->kept(), device->kept())) << family->name;
        EXPECT_EQ(other->flash_writes(), device->flash_writes()) << family->name;
    }
}

TEST(Devices, RefuseAFlashThatTheyCannotHaveAndChangeNothing)
{
    const auto complaint = [](std::string_view family, std::string_view lines) {
        const auto spec = make_spec(*find_family(family), family == "sam" ? "SAM-160" : "", "", 1);
        const auto device = make_device(*spec, plant_of(*spec));
        device->run(supply_v(*spec));
        const auto before = device->kept();
        const auto flash = config::parse_flash_file(
            fmt::format("version = 1\n[joint.elbow]\nfamily = \"{}\"\n{}", family, lines), "flash.toml");
        const auto restored = device->restore(*flash, flash->joints.front());
        EXPECT_FALSE(restored) << lines;
        EXPECT_TRUE(same(device->kept(), before)) << lines;
        return restored ? std::string() : to_sentence(restored.error());
    };
    EXPECT_EQ(complaint("sam", "i_gain = 3\np_gian = 3\n"),
              "flash.toml:5:1: the sam of elbow keeps no 'p_gian', did you mean p_gain?");
    EXPECT_EQ(complaint("sam", "id = 255\n"), "flash.toml:4:1: id must be a whole number from 0 to 254.");
    EXPECT_EQ(complaint("nuri", "gear_ratio = \"one\"\n"),
              "flash.toml:4:1: gear_ratio must be a whole number from 1 to 65533.");
    EXPECT_EQ(complaint("rmd", "writes = -1\n"), "flash.toml:4:1: writes must be a whole number from 0 to 4294967295.");
    EXPECT_EQ(complaint("sam", "lower_boundary = 20\nupper_boundary = 20\n"),
              "flash.toml:2:8: a lower boundary of elbow is not below the upper one.");
}

} // namespace
} // namespace sinew::sim
