#include "sinew/record/recovery.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sinew::record {
namespace {

using mcap::Opcode;

/// What a file holds, as words; errors end with their own.
struct Content {
    std::vector<std::string> words;
    std::vector<std::string> errors;
};

Content content_of(std::string_view file)
{
    mcap::Reader reader;
    reader.feed(bytes_of(file));
    reader.end();
    Content out;
    for (;;) {
        const auto item = reader.next();
        if (!item) {
            out.errors.push_back(item.error().detail);
            continue;
        }
        if (!*item)
            return out;
        if (const auto* m = std::get_if<mcap::Message>(&**item)) {
            const auto* schema = reader.schema(m->channel->schema_id);
            out.words.push_back(fmt::format("{} {} {} {} {} {}", m->channel->topic,
                                            schema != nullptr ? schema->name : "-", m->stamp.sequence,
                                            m->stamp.log_time_ns, m->stamp.publish_time_ns, text_of(m->data)));
        } else if (const auto* a = std::get_if<mcap::Attachment>(&**item)) {
            out.words.push_back(fmt::format("attachment {} {}", a->name, a->data));
        } else {
            out.words.push_back(fmt::format("metadata {}", std::get<mcap::Metadata>(**item).name));
        }
    }
}

/// Channels that come late, several chunks, an attachment and metadata between them.
std::string recording()
{
    mcap::Writer writer;
    const auto schema = writer.add_schema({.name = "state", .encoding = "jsonschema", .data = "{}"});
    writer.attach({.log_time_ns = 1, .name = "robot.toml", .media_type = "application/toml", .data = "version = 1"});
    std::vector<std::uint16_t> channels;
    std::uint32_t number = 0;
    for (int chunk = 0; chunk < 4; ++chunk) {
        channels.push_back(
            writer.add_channel({.schema_id = schema, .topic = fmt::format("/c{}", chunk), .message_encoding = "json"}));
        for (int i = 0; i < 5; ++i, ++number)
            writer.add(channels[number % channels.size()],
                       {.sequence = number, .log_time_ns = 100 + number, .publish_time_ns = 100 + number},
                       bytes_of(fmt::format("{{\"n\":{}}}", number)));
        writer.close_chunk();
        writer.add(mcap::Metadata{.name = fmt::format("m{}", chunk), .pairs = {{"a", "b"}}});
    }
    writer.finish();
    return std::string(writer.pending());
}

/// Where each thing that a reader tells is whole, in the order of the file: the end of its record.
std::vector<std::size_t> ends_of_things(std::string_view file)
{
    std::vector<std::size_t> out;
    for (std::size_t at = mcap::magic.size(); at + mcap::magic.size() < file.size();) {
        const auto opcode = static_cast<Opcode>(file[at]);
        const std::size_t end = at + mcap::record_head + get_number(bytes_of(file.substr(at + 1, 8)));
        if (opcode == Opcode::data_end)
            return out;
        if (opcode == Opcode::attachment || opcode == Opcode::metadata)
            out.push_back(end);
        if (opcode == Opcode::chunk)
            for (std::size_t in = at + mcap::record_head + 40; in < end;) {
                in += mcap::record_head + get_number(bytes_of(file.substr(in + 1, 8)));
                out.push_back(in);
            }
        at = end;
    }
    return out;
}

std::expected<std::string, Error> recovered(std::string_view file, std::size_t piece, bool& was_whole)
{
    Recovery recovery;
    std::string out;
    const auto take = [&] {
        out += recovery.pending();
        recovery.written();
    };
    for (std::size_t at = 0; at < file.size(); at += piece) {
        recovery.feed(bytes_of(file.substr(at, piece)));
        take();
    }
    const auto ended = recovery.end();
    take();
    was_whole = recovery.problems().empty();
    return ended ? std::expected<std::string, Error>(out) : std::unexpected(ended.error());
}

TEST(Recovery, FromEveryByteAtWhichAFileCanEndComesAWholeFileWithEverythingThatWasWhole)
{
    const std::string file = recording();
    const auto all = content_of(file);
    ASSERT_TRUE(all.errors.empty());
    const auto ends = ends_of_things(file);
    ASSERT_EQ(ends.size(), all.words.size());
    ASSERT_EQ(all.words.size(), 25U);
    for (std::size_t cut = 0; cut <= file.size(); ++cut) {
        bool was_whole = false;
        const auto out = recovered(std::string_view(file).substr(0, cut), 1000, was_whole);
        ASSERT_EQ(out.has_value(), cut >= mcap::magic.size()) << cut;
        EXPECT_EQ(was_whole, cut == file.size()) << cut;
        if (!out)
            continue;
        const auto got = content_of(*out);
        ASSERT_EQ(got.errors, std::vector<std::string>{}) << cut;
        const auto whole = static_cast<std::ptrdiff_t>(
            std::count_if(ends.begin(), ends.end(), [&](std::size_t end) { return end <= cut; }));
        // Attachments and metadata go out at once, messages with their chunk: the order between them may change.
        auto expected = std::vector(all.words.begin(), all.words.begin() + whole);
        auto words = got.words;
        std::sort(expected.begin(), expected.end());
        std::sort(words.begin(), words.end());
        ASSERT_EQ(words, expected) << cut;
    }
}

TEST(Recovery, KeepsWhatStandsBehindADamagedChunk)
{
    std::string file = recording();
    file[file.find("{\"n\":7}") + 5] = '8';
    bool was_whole = true;
    const auto out = recovered(file, 1 << 20, was_whole);
    ASSERT_TRUE(out);
    EXPECT_FALSE(was_whole);
    EXPECT_EQ(content_of(*out).words.size(), 20U);
}

TEST(Recovery, OfSomethingElseIsAnErrorAndNoFile)
{
    bool was_whole = true;
    const auto out = recovered("(1.0) can0 141#00\n", 3, was_whole);
    ASSERT_FALSE(out);
    EXPECT_NE(to_sentence(out.error()).find("no MCAP file"), std::string::npos);
}

} // namespace
} // namespace sinew::record
