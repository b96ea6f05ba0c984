#include "sinew/record/mcap_frames.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::record {
namespace {

using wire::Direction;
using namespace std::chrono_literals;

const std::vector<Captured> traffic{
    {.at = Time{1436509052249713001ns},
     .bus = "legs",
     .family = "rmd",
     .direction = Direction::request,
     .kind = Captured::Kind::can,
     .frame = {.can_id = 0x141, .size = 8, .data = {0x9A}}},
    {.at = Time{1436509052249999002ns},
     .bus = "left",
     .family = "sam",
     .direction = Direction::reply,
     .bytes = {1, 2, 3},
     .discarded = "nobody asked for it"},
    {.at = Time{1436509053s}, .bus = "left", .family = "sam", .bytes = {0xFF}},
    {.at = Time{1436509054s}, .kind = Captured::Kind::can_remote, .extended = true, .frame = {.can_id = 5, .size = 8}},
    {.at = Time{1436509055s}, .kind = Captured::Kind::can_error, .frame = {.can_id = 4, .size = 8, .data = {0, 16}}},
    {.at = Time{0s}, .bus = "left", .family = "sam"},
};

std::string written(bool finish)
{
    McapFrameWriter writer;
    std::string out;
    for (const auto& one : traffic)
        EXPECT_TRUE(writer.add(one, out));
    finish ? writer.finish(out) : writer.flush(out);
    return out;
}

struct Read {
    std::vector<Captured> frames;
    std::vector<std::string> errors;
};

Read read(std::string_view file)
{
    McapFrameReader reader;
    reader.feed(bytes_of(file));
    reader.end();
    Read out;
    for (;;) {
        const auto one = reader.next();
        if (!one)
            out.errors.push_back(one.error().detail);
        else if (*one)
            out.frames.push_back(**one);
        else
            return out;
    }
}

TEST(Topics, FramesAreReadAsTheyWereWritten)
{
    const auto got = read(written(true));
    EXPECT_EQ(got.frames, traffic);
    EXPECT_EQ(got.errors, std::vector<std::string>{});
}

TEST(Topics, WhatWasFlushedCanBeReadWithoutTheEnd)
{
    const auto got = read(written(false));
    EXPECT_EQ(got.frames, traffic);
    ASSERT_EQ(got.errors.size(), 1U);
    EXPECT_NE(got.errors[0].find("without the record that ends its data"), std::string::npos);
}

TEST(Topics, AVerdictIsWhyAFrameWasDiscardedUnlessItWasNot)
{
    const auto frame = [](bus::Verdict verdict) {
        const std::uint8_t bytes[] = {1, 2};
        std::string text;
        put_frame(text, {.direction = Direction::reply, .bytes = bytes, .verdict = verdict}, false);
        const mcap::Channel channel{.metadata = {{"bus", "left"}, {"family", "sam"}}};
        return frame_from({.channel = &channel, .stamp = {.log_time_ns = 5}, .data = bytes_of(text)});
    };
    EXPECT_EQ(
        *frame(bus::Verdict::taken),
        (Captured{.at = Time{5ns}, .bus = "left", .family = "sam", .direction = Direction::reply, .bytes = {1, 2}}));
    EXPECT_EQ(frame(bus::Verdict::bad_checksum)->discarded, "bad_checksum");
    EXPECT_EQ(frame(bus::Verdict::late)->discarded, "late");
}

TEST(Topics, RefusesFramesThatCannotBe)
{
    const mcap::Channel channel;
    const auto why = [&](std::string_view text, std::uint64_t time = 0) {
        const auto frame = frame_from({.channel = &channel, .stamp = {.log_time_ns = time}, .data = bytes_of(text)});
        return frame ? std::string{} : to_sentence(frame.error());
    };
    EXPECT_NE(why("nonsense").find("no JSON object"), std::string::npos);
    EXPECT_NE(why(R"({"bytes":"0G"})").find("no hex"), std::string::npos);
    EXPECT_NE(why(R"({"can_id":-1,"bytes":""})").find("cannot be on CAN"), std::string::npos);
    EXPECT_NE(why(R"({"can_id":321,"bytes":"00 01 02 03 04 05 06 07 08"})").find("cannot be on CAN"),
              std::string::npos);
    EXPECT_NE(why(R"({"bytes":""})", ~0ULL).find("beyond the year"), std::string::npos);
}

TEST(Topics, EverySchemaIsJsonThatNamesEveryColumnWithItsType)
{
    for (const auto topic : {Topic::frame, Topic::state, Topic::command, Topic::event}) {
        const auto schema = schema_of(topic);
        EXPECT_EQ(schema.encoding, "jsonschema");
        EXPECT_TRUE(JsonFields::parse(schema.data)) << schema.data;
        for (const auto& column : columns_of(topic))
            EXPECT_NE(schema.data.find(fmt::format("\"{}\":{{\"type\"", column.name)), std::string::npos);
    }
}

} // namespace
} // namespace sinew::record
