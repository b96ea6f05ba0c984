#include "sinew/config/flash_file.hpp"

#include <gtest/gtest.h>

namespace sinew::config {
namespace {

std::string complaint(std::string_view text)
{
    const auto file = parse_flash_file(text, "f.toml");
    return file ? std::string() : to_sentence(file.error());
}

TEST(FlashFile, HasTheValuesOfEachJointWithTheirPlaces)
{
    const auto file =
        parse_flash_file("version = 1\n[joint.b]\nfamily = \"sam\"\nid = 3\n[joint.a]\nfamily = \"rmd\"\n", "f.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    ASSERT_EQ(file->joints.size(), 2U);
    EXPECT_EQ(file->joints[0].name, "b");
    EXPECT_EQ(file->joints[0].family.value, "sam");
    ASSERT_EQ(file->joints[0].values.size(), 1U);
    EXPECT_EQ(file->joints[0].values[0].key, "id");
    EXPECT_EQ(std::get<std::int64_t>(file->joints[0].values[0].value), 3);
    EXPECT_EQ(file->joints[0].values[0].at.line, 4U);
    EXPECT_EQ(file->joints[1].name, "a");
}

TEST(FlashFile, SaysWhereItIsWrong)
{
    EXPECT_EQ(complaint(""), "f.toml:1:1: a flash file needs version = 1.");
    EXPECT_EQ(complaint("version = 2\n"), "f.toml:1:11: version 2 is not known; this sinew reads version 1.");
    EXPECT_EQ(complaint("version = 1\n[joint.a]\nid = 3\n"), "f.toml:2:8: joint a needs family.");
    EXPECT_EQ(complaint("version = 1\n[jiont.a]\n"),
              "f.toml:2:2: a flash file has no key 'jiont', did you mean joint?");
    EXPECT_EQ(complaint("version = 1\n[joint.a]\nfamily = \"sam\"\nid = [3]\n").find("f.toml:4:1: id must be"), 0U);
    EXPECT_EQ(complaint("version = 1\n[joint.a]\nfamily = \"sam\"\nid = \n").find("f.toml:4:"), 0U) << "torn";
}

} // namespace
} // namespace sinew::config
