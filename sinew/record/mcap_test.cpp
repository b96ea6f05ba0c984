#include "sinew/record/mcap_reader.hpp"

#include "sinew/record/crc32.hpp"

#include <gtest/gtest.h>

namespace sinew::record::mcap {
namespace {

/// A message with its channel's topic, by value.
struct Told {
    std::string topic;
    Stamp stamp;
    std::string data;

    friend bool operator==(const Told& a, const Told& b)
    {
        return a.topic == b.topic && a.data == b.data && a.stamp.sequence == b.stamp.sequence &&
               a.stamp.log_time_ns == b.stamp.log_time_ns && a.stamp.publish_time_ns == b.stamp.publish_time_ns;
    }
};

struct Read {
    std::vector<Told> messages;
    std::vector<Attachment> attachments;
    std::vector<Metadata> metadata;
    std::vector<std::string> errors;
    bool finished = false;
};

Read read(std::string_view file, std::size_t piece = 1 << 20)
{
    Reader reader;
    Read out;
    const auto drain = [&] {
        for (;;) {
            const auto item = reader.next();
            if (!item)
                out.errors.push_back(item.error().detail);
            else if (!*item)
                return;
            else if (const auto* m = std::get_if<Message>(&**item))
                out.messages.push_back({m->channel->topic, m->stamp, std::string(text_of(m->data))});
            else if (const auto* a = std::get_if<Attachment>(&**item))
                out.attachments.push_back(*a);
            else
                out.metadata.push_back(std::get<Metadata>(**item));
        }
    };
    for (std::size_t at = 0; at < file.size(); at += piece) {
        reader.feed(bytes_of(file.substr(at, piece)));
        drain();
    }
    reader.end();
    drain();
    out.finished = reader.was_finished();
    return out;
}

const Attachment robot{.log_time_ns = 5,
                       .create_time_ns = 4,
                       .name = "robot.toml",
                       .media_type = "application/toml",
                       .data = "version = 1\n"};
const Metadata made{.name = "sinew", .pairs = {{"time", "utc"}, {"host", "a"}}};

/// Two channels, two chunks of two messages each, an attachment and metadata.
std::string sample()
{
    Writer writer;
    const auto schema = writer.add_schema({.name = "s", .encoding = "jsonschema", .data = "{}"});
    const auto one = writer.add_channel({.schema_id = schema, .topic = "/one", .message_encoding = "json"});
    writer.attach(robot);
    writer.add(one, {.sequence = 1, .log_time_ns = 10, .publish_time_ns = 9}, bytes_of("{\"a\":1}"));
    const auto two = writer.add_channel({.topic = "/two", .message_encoding = "json", .metadata = {{"k", "v"}}});
    writer.add(two, {.sequence = 7, .log_time_ns = 12, .publish_time_ns = 12}, bytes_of(""));
    writer.close_chunk();
    writer.add(made);
    writer.add(one, {.sequence = 2, .log_time_ns = 30, .publish_time_ns = 30}, bytes_of("{\"a\":2}"));
    writer.add(one, {.sequence = 3, .log_time_ns = 20, .publish_time_ns = 20}, bytes_of("{\"a\":3}"));
    writer.finish();
    return std::string(writer.pending());
}

const std::vector<Told> told{{"/one", {1, 10, 9}, "{\"a\":1}"},
                             {"/two", {7, 12, 12}, ""},
                             {"/one", {2, 30, 30}, "{\"a\":2}"},
                             {"/one", {3, 20, 20}, "{\"a\":3}"}};

/// The records of a file: opcode, content, and where they begin.
struct Raw {
    Opcode opcode;
    std::string_view content;
    std::size_t at;
};
std::vector<Raw> records(std::string_view file)
{
    std::vector<Raw> out;
    for (std::size_t at = magic.size(); at + magic.size() < file.size();) {
        const auto size = get_number(bytes_of(file.substr(at + 1, 8)));
        out.push_back({static_cast<Opcode>(file[at]), file.substr(at + record_head, size), at});
        at += record_head + size;
    }
    return out;
}

TEST(Mcap, ReadsInPiecesOfAnySizeWhatItWrote)
{
    const std::string file = sample();
    for (const std::size_t piece : {1, 2, 3, 7, 64, 100'000}) {
        const auto got = read(file, piece);
        EXPECT_EQ(got.errors, std::vector<std::string>{}) << piece;
        EXPECT_EQ(got.messages, told) << piece;
        EXPECT_EQ(got.attachments, std::vector{robot});
        EXPECT_EQ(got.metadata, std::vector{made});
        EXPECT_TRUE(got.finished);
    }
}

TEST(Mcap, TheSummarySaysWhereEverythingStands)
{
    const std::string file = sample();
    const auto all = records(file);
    ASSERT_EQ(all.back().opcode, Opcode::footer);
    Fields footer(bytes_of(all.back().content));
    const auto summary = footer.number(8), offsets = footer.number(8), crc = footer.number(4);
    EXPECT_EQ(crc, crc32(bytes_of(std::string_view(file).substr(summary, file.size() - magic.size() - 4 - summary))));
    const auto record_at = [&](std::uint64_t at) {
        for (const auto& one : all)
            if (one.at == at)
                return one;
        ADD_FAILURE() << "no record begins at " << at;
        return Raw{};
    };
    EXPECT_EQ(record_at(summary).opcode, Opcode::schema);
    EXPECT_EQ(record_at(offsets).opcode, Opcode::summary_offset);
    int chunks = 0, groups = 0;
    for (const auto& one : all) {
        Fields in(bytes_of(one.content));
        if (one.opcode == Opcode::chunk_index) {
            ++chunks;
            const auto start = in.number(8), end = in.number(8), at = in.number(8), length = in.number(8);
            const auto chunk = record_at(at);
            EXPECT_EQ(chunk.opcode, Opcode::chunk);
            EXPECT_EQ(chunk.content.size() + record_head, length);
            EXPECT_EQ(get_number(bytes_of(chunk.content.substr(0, 8))), start);
            EXPECT_EQ(get_number(bytes_of(chunk.content.substr(8, 8))), end);
            Fields places(in.bytes(4));
            while (!places.rest().empty()) {
                const auto channel = places.number(2);
                const auto index = record_at(places.number(8));
                EXPECT_EQ(index.opcode, Opcode::message_index);
                EXPECT_EQ(get_number(bytes_of(index.content.substr(0, 2))), channel);
            }
        } else if (one.opcode == Opcode::summary_offset) {
            ++groups;
            const auto kind = in.number(1);
            EXPECT_EQ(static_cast<std::uint64_t>(record_at(in.number(8)).opcode), kind);
        } else if (one.opcode == Opcode::statistics) {
            EXPECT_EQ(in.number(8), told.size());
            EXPECT_EQ(in.number(2), 1U); // schemas
            EXPECT_EQ(in.number(4), 2U); // channels
            EXPECT_EQ(in.number(4), 1U);
            EXPECT_EQ(in.number(4), 1U);
            EXPECT_EQ(in.number(4), 2U); // chunks
            EXPECT_EQ(in.number(8), 10U);
            EXPECT_EQ(in.number(8), 30U);
        } else if (one.opcode == Opcode::attachment_index || one.opcode == Opcode::metadata_index) {
            EXPECT_EQ(record_at(in.number(8)).opcode,
                      one.opcode == Opcode::attachment_index ? Opcode::attachment : Opcode::metadata);
        }
    }
    EXPECT_EQ(chunks, 2);
    EXPECT_EQ(groups, 6);
}

TEST(Mcap, AChunkIsClosedWhenItHasGrownLarge)
{
    Writer writer;
    const auto channel = writer.add_channel({.topic = "/x"});
    const std::string large(Writer::chunk_size / 2, 'x');
    writer.written();
    writer.add(channel, {}, bytes_of(large));
    EXPECT_TRUE(writer.pending().empty());
    writer.add(channel, {}, bytes_of(large));
    EXPECT_GT(writer.pending().size(), Writer::chunk_size);
    EXPECT_FALSE(writer.has_open_chunk());
}

TEST(Mcap, WhatCouldNotBeWrittenIsNotInTheSummary)
{
    Writer writer;
    const auto channel = writer.add_channel({.topic = "/x"});
    writer.add(channel, {.log_time_ns = 1}, bytes_of("kept"));
    writer.close_chunk();
    std::string file(writer.pending());
    writer.written();
    writer.add(channel, {.log_time_ns = 2}, bytes_of("lost"));
    writer.attach(robot);
    writer.close_chunk();
    writer.drop_pending();
    writer.finish();
    file += writer.pending();
    const auto got = read(file);
    EXPECT_EQ(got.errors, std::vector<std::string>{});
    EXPECT_EQ(got.messages, (std::vector<Told>{{"/x", {.log_time_ns = 1}, "kept"}}));
    EXPECT_EQ(writer.messages(), 1U);
    int chunks = 0, attachments = 0;
    for (const auto& one : records(file)) {
        chunks += one.opcode == Opcode::chunk_index;
        attachments += one.opcode == Opcode::attachment_index;
        if (one.opcode == Opcode::statistics) {
            EXPECT_EQ(get_number(bytes_of(one.content.substr(0, 8))), 1U);
        }
    }
    EXPECT_EQ(chunks, 1);
    EXPECT_EQ(attachments, 0);
}

TEST(Mcap, AChunkWithAFlippedBitIsPassedOverWithAnError)
{
    std::string file = sample();
    for (const auto& one : records(file))
        if (one.opcode == Opcode::chunk) {
            file[one.at + record_head + one.content.size() - 2] ^= 1;
            break;
        }
    const auto got = read(file);
    EXPECT_EQ(got.messages, (std::vector{told[2], told[3]}));
    ASSERT_EQ(got.errors.size(), 1U);
    EXPECT_NE(got.errors[0].find("checksum"), std::string::npos);
}

TEST(Mcap, SaysWhatIsWrongWithAFile)
{
    const auto why = [](std::string_view file) {
        const auto got = read(file);
        return got.errors.empty() ? std::string{} : got.errors.front();
    };
    EXPECT_EQ(why("(1.0) can0 141#00\n"), "offset 0: this is no MCAP file");
    EXPECT_EQ(why(""), "offset 0: this is no MCAP file");
    EXPECT_NE(why(std::string(magic)).find("without the record that ends its data"), std::string::npos);
    std::string file = sample();
    file.back() = 'x';
    EXPECT_NE(why(file).find("does not end as it must"), std::string::npos);
    const auto content = [](Opcode opcode, std::string_view bytes) {
        std::string out(magic);
        put_record(out, opcode, bytes);
        return out;
    };
    EXPECT_NE(why(content(Opcode::message, std::string(22, '\3'))).find("channel 771"), std::string::npos);
    EXPECT_NE(why(content(Opcode::channel, "x")).find("too short"), std::string::npos);
    std::string packed(28, '\0');
    put_text(packed, "zstd");
    put_number(packed, 0, 8);
    EXPECT_NE(why(content(Opcode::chunk, packed)).find("is compressed with zstd"), std::string::npos);
    std::string nested(28, '\0');
    put_text(nested, "");
    put_number(nested, 9, 8);
    put_record(nested, Opcode::chunk, "");
    nested[16] = 9;
    EXPECT_NE(why(content(Opcode::chunk, nested)).find("inside a chunk"), std::string::npos);
}

} // namespace
} // namespace sinew::record::mcap
