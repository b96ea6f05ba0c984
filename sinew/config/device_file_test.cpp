#include "sinew/config/device_file.hpp"

#include <gtest/gtest.h>

namespace sinew::config {
namespace {

constexpr std::string_view text = R"(version = 1

[device.elbow]
family = "sam"
note = "a \"word\" \\ and a bell \u0007"
id = 3
share = 0.5
[device.elbow.settings]
pd-gain = { p_gain = 30, d_gain = 20 }
[device.elbow.calibration]
encoder-offset = { encoder_offset = 100 }

[device.knee]
family = "rmd"
)";

TEST(DeviceFile, IsWrittenAsItIsRead)
{
    const auto file = parse_device_file(text, "kept.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    EXPECT_EQ(to_toml(*file), text);
}

TEST(DeviceFile, TellsFactsAndSettingsApart)
{
    const auto file = parse_device_file(text, "kept.toml");
    ASSERT_TRUE(file);
    const auto* elbow = file->find("elbow");
    ASSERT_NE(elbow, nullptr);
    EXPECT_EQ(elbow->text("family"), "sam");
    EXPECT_EQ(elbow->whole("id"), 3);
    EXPECT_EQ(elbow->whole("family"), std::nullopt);
    ASSERT_EQ(elbow->settings.size(), 1U);
    EXPECT_EQ(elbow->settings[0].name, "pd-gain");
    EXPECT_EQ(elbow->settings[0].values.size(), 2U);
    ASSERT_EQ(elbow->calibration.size(), 1U);
    EXPECT_EQ(file->find("wrist"), nullptr);
}

TEST(DeviceFile, NamesThePlaceOfWhatIsWrong)
{
    const auto wrong = parse_device_file("version = 1\n[device.a]\n[device.a.settings]\npd-gain = 3\n", "kept.toml");
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, Errc::bad_file);
    EXPECT_NE(to_sentence(wrong.error()).find("kept.toml:4:"), std::string::npos) << to_sentence(wrong.error());
    EXPECT_FALSE(parse_device_file("version = 2\n", "kept.toml"));
    EXPECT_FALSE(parse_device_file("version = 1\ndevices = 1\n", "kept.toml"));
}

} // namespace
} // namespace sinew::config
