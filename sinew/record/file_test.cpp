#include "sinew/record/file.hpp"

#include "sinew/record/tap.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sinew::record {
namespace {

class FileTest : public testing::Test
{
protected:
    FileTest() : folder_(std::filesystem::temp_directory_path() / fmt::format("sinew-file-{}", ::getpid()))
    {
        std::filesystem::create_directories(folder_);
    }
    ~FileTest() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path folder_;
};

const std::vector<Captured> traffic{{.at = Time{Duration{1'000'000'000}},
                                     .bus = "legs",
                                     .direction = wire::Direction::request,
                                     .kind = Captured::Kind::can,
                                     .frame = {.can_id = 0x141, .size = 8, .data = {0x9A}}},
                                    {.at = Time{Duration{1'000'250'000}},
                                     .bus = "legs",
                                     .direction = wire::Direction::reply,
                                     .kind = Captured::Kind::can,
                                     .frame = {.can_id = 0x141, .size = 8, .data = {0x9A, 20}}}};

std::vector<Captured> read(const std::filesystem::path& path)
{
    auto file = FileReader::open(path);
    std::vector<Captured> out;
    for (auto one = file->next(); one && *one; one = file->next())
        out.push_back(**one);
    return out;
}

TEST_F(FileTest, EveryFormatIsToldByItsFirstBytesAndGivesWhatWasWritten)
{
    for (const auto* name : {"a.log", "a.pcapng", "a.mcap"}) {
        auto file = FileWriter::create(folder_ / name);
        ASSERT_TRUE(file) << name;
        for (const auto& one : traffic)
            ASSERT_TRUE(file->add(one));
        ASSERT_TRUE(file->finish());
        EXPECT_FALSE(file->add(traffic[0])) << "it is finished";
        std::filesystem::rename(folder_ / name, folder_ / "a");
        EXPECT_EQ(read(folder_ / "a"), traffic) << name;
    }
}

TEST_F(FileTest, WhatWasFlushedIsThereBeforeTheEnd)
{
    for (const auto* name : {"a.log", "a.pcapng", "a.mcap"}) {
        auto file = FileWriter::create(folder_ / name);
        ASSERT_TRUE(file->add(traffic[0]));
        ASSERT_TRUE(file->flush());
        EXPECT_EQ(read(folder_ / name).size(), 1U) << name;
    }
}

TEST_F(FileTest, OtherEndingsAndPlacesAreRefused)
{
    EXPECT_NE(FileWriter::create(folder_ / "a.txt").error().detail.find(".mcap"), std::string::npos);
    EXPECT_FALSE(FileWriter::create(folder_ / "no" / "a.mcap"));
    EXPECT_FALSE(FileReader::open(folder_));
    EXPECT_FALSE(FileReader::open(folder_ / "no.mcap"));
}

TEST(Tap, TellsWhyTheHostThrewAFrameAway)
{
    const std::uint8_t bytes[] = {1, 2};
    const auto discarded = [&](bus::Verdict verdict) {
        return captured_from({.direction = wire::Direction::reply, .bytes = bytes, .verdict = verdict}, "left", "sam",
                             false)
            .discarded;
    };
    EXPECT_EQ(discarded(bus::Verdict::sent), "");
    EXPECT_EQ(discarded(bus::Verdict::taken), "");
    EXPECT_EQ(discarded(bus::Verdict::late), "late");
    EXPECT_EQ(discarded(bus::Verdict::bad_checksum), "bad_checksum");
    EXPECT_EQ(discarded(bus::Verdict::quarantined), "quarantined");
}

} // namespace
} // namespace sinew::record
