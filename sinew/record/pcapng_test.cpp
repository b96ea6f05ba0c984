#include "sinew/record/pcapng.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::record {
namespace {

using wire::Direction;
using namespace std::chrono_literals;

struct Read {
    std::vector<Captured> frames;
    std::vector<std::string> errors;
};

Read read(std::string_view text, std::size_t piece = 1 << 16)
{
    PcapngReader reader;
    Read out;
    const auto drain = [&] {
        for (;;) {
            auto one = reader.next();
            if (!one)
                out.errors.push_back(one.error().detail);
            else if (*one)
                out.frames.push_back(**one);
            else
                return;
        }
    };
    for (std::size_t at = 0; at < text.size(); at += piece) {
        const auto part = text.substr(at, piece);
        reader.feed({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
        drain();
    }
    reader.end();
    drain();
    return out;
}

std::string written(const std::vector<Captured>& all)
{
    std::string out;
    PcapngWriter writer;
    for (const auto& one : all)
        EXPECT_TRUE(writer.add(one, out));
    return out;
}

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
};

/// The blocks of a file, each with its first byte.
std::vector<std::size_t> blocks(std::string_view file)
{
    std::vector<std::size_t> out;
    for (std::size_t at = 0; at < file.size();) {
        out.push_back(at);
        at += static_cast<std::uint8_t>(file[at + 4]) + 256U * static_cast<std::uint8_t>(file[at + 5]);
    }
    return out;
}

/// The same file as a machine of the other byte order writes it, where all options are text.
std::string big_endian(std::string file)
{
    const auto swap = [&](std::size_t at, std::size_t size) { std::reverse(&file[at], &file[at] + size); };
    for (const std::size_t at : blocks(file)) {
        const auto type = static_cast<std::uint8_t>(file[at]);
        const std::size_t size = static_cast<std::uint8_t>(file[at + 4]);
        std::size_t option = at + (type == 1 ? 16 : type == 6 ? 28 : 24);
        if (type == 6) {
            option += (static_cast<std::uint8_t>(file[at + 20]) + 3U) / 4 * 4;
            for (std::size_t i = 8; i < 28; i += 4)
                swap(at + i, 4);
        } else if (type == 1) {
            swap(at + 8, 2);
        } else {
            swap(at + 8, 4);
            swap(at + 12, 2);
        }
        while (option + 4 < at + size) {
            const std::size_t length = static_cast<std::uint8_t>(file[option + 2]);
            if (type == 6 && file[option] == 2)
                swap(option + 4, 4);
            swap(option, 2);
            swap(option + 2, 2);
            option += 4 + (length + 3) / 4 * 4;
        }
        swap(at, 4);
        swap(at + 4, 4);
        swap(at + size - 4, 4);
    }
    return file;
}

TEST(Pcapng, ReadsInPiecesOfAnySizeWhatItWrote)
{
    const std::string file = written(traffic);
    for (const std::size_t piece : {1, 2, 3, 7, 64, 100'000}) {
        const auto got = read(file, piece);
        EXPECT_EQ(got.frames, traffic) << piece;
        EXPECT_EQ(got.errors, std::vector<std::string>{}) << piece;
    }
}

TEST(Pcapng, ReadsTheOtherByteOrder)
{
    const auto got = read(big_endian(written(traffic)));
    EXPECT_EQ(got.errors, std::vector<std::string>{});
    EXPECT_EQ(got.frames, traffic);
}

TEST(Pcapng, ReadsFilesOneAfterTheOther)
{
    const auto got = read(written({traffic[0]}) + big_endian(written({traffic[1]})) + written({traffic[2]}));
    EXPECT_EQ(got.frames, (std::vector{traffic[0], traffic[1], traffic[2]}));
}

TEST(Pcapng, ReadsEveryResolutionOfTime)
{
    // Two packets of one tick and of 2^32 ticks at each resolution.
    const auto time_at = [](std::uint8_t resolution, std::uint32_t high, std::uint32_t low) {
        std::string file = written({{.at = Time{Duration{(std::int64_t{high} << 32) + low}}, .bytes = {1}}});
        const auto place = file.find(std::string("\x09\x00\x01\x00\x09", 5));
        EXPECT_NE(place, std::string::npos);
        file[place + 4] = static_cast<char>(resolution);
        const auto got = read(file);
        EXPECT_EQ(got.frames.size(), 1U) << (got.errors.empty() ? "" : got.errors[0]);
        return got.frames.empty() ? Duration{-1} : got.frames[0].at.time_since_epoch();
    };
    EXPECT_EQ(time_at(9, 0, 5), 5ns);
    EXPECT_EQ(time_at(6, 0, 5), 5us);
    EXPECT_EQ(time_at(0, 0, 5), 5s);
    EXPECT_EQ(time_at(12, 0, 5000), 5ns);
    EXPECT_EQ(time_at(0x80 | 10, 0, 1536), 1500ms);
    EXPECT_EQ(time_at(0x80 | 32, 1, 0x8000'0000), 1500ms);
    EXPECT_EQ(time_at(0x80 | 63, 0x4000'0000, 0), 500ms);
}

TEST(Pcapng, GivesAllBeforeTheCutOfATruncatedFileAndSaysWhere)
{
    const std::string file = written(traffic);
    const auto starts = blocks(file);
    for (std::size_t cut = 1; cut < file.size(); ++cut) {
        const auto got = read(std::string_view(file).substr(0, cut));
        std::size_t whole = 0;
        for (std::size_t i = 0; i < starts.size(); ++i) {
            const std::size_t end = i + 1 < starts.size() ? starts[i + 1] : file.size();
            whole += file[starts[i]] == 6 && end <= cut;
        }
        EXPECT_EQ(got.frames.size(), whole) << cut;
        const auto in = std::ranges::find(starts, cut);
        if (in != starts.end()) {
            EXPECT_TRUE(got.errors.empty()) << cut;
            continue;
        }
        const auto block = *std::prev(std::ranges::upper_bound(starts, cut));
        ASSERT_EQ(got.errors.size(), 1U) << cut;
        EXPECT_EQ(got.errors[0],
                  "offset " + std::to_string(block) + ": the file ends inside this block; all before it was read");
    }
}

TEST(Pcapng, GoesOnAfterAPacketThatItCannotRead)
{
    std::string file = written({traffic[0], traffic[1], traffic[2]});
    const auto starts = blocks(file);
    file[starts[1] + 8] = 1; // Ethernet
    const auto got = read(file);
    EXPECT_EQ(got.frames, (std::vector{traffic[1], traffic[2]}));
    ASSERT_EQ(got.errors.size(), 1U);
    EXPECT_EQ(got.errors[0],
              "offset " + std::to_string(starts[2]) + ": a packet of link type 1; 227 (CAN) and 147 (serial) are read");
}

TEST(Pcapng, SaysWhatIsWrongWithAFile)
{
    const auto why = [](const std::string& file) {
        const auto got = read(file);
        return got.errors.empty() ? std::string{} : got.errors.front();
    };
    const std::string good = written({traffic[0]});
    const auto starts = blocks(good);
    EXPECT_NE(why("(1.0) can0 141#00\n").find("no pcapng file"), std::string::npos);
    const auto with = [&](std::size_t at, int value) {
        std::string file = good;
        file[at] = static_cast<char>(value);
        return why(file);
    };
    EXPECT_NE(with(8, 0).find("byte-order mark"), std::string::npos);
    EXPECT_NE(with(12, 2).find("version 2"), std::string::npos);
    EXPECT_NE(with(starts[1] + 4, 3).find("3 bytes long"), std::string::npos);
    EXPECT_NE(with(good.size() - 4, 1).find("at its end"), std::string::npos);
    EXPECT_NE(with(starts[2] + 8, 9).find("interface 9"), std::string::npos);
    EXPECT_NE(with(starts[2] + 20, 200).find("a packet of 200 bytes"), std::string::npos);
    EXPECT_NE(with(starts[2] + 24, 99).find("99 bytes of which"), std::string::npos);
    EXPECT_NE(with(starts[2] + 28 + 4, 9).find("CAN FD"), std::string::npos);
}

TEST(Pcapng, ReadsNoPacketWithAResolutionOfTimeThatCannotBe)
{
    std::string file = written({traffic[0], traffic[1]});
    const auto starts = blocks(file);
    file[file.find(std::string("\x09\x00\x01\x00\x09", 5)) + 4] = static_cast<char>(0x80 | 120);
    const auto got = read(file);
    EXPECT_EQ(got.frames, std::vector{traffic[1]});
    ASSERT_EQ(got.errors.size(), 2U);
    EXPECT_EQ(got.errors[0], "offset " + std::to_string(starts[1]) + ": a resolution of time of 0xf8");
    EXPECT_NE(got.errors[1].find("whose description could not be read"), std::string::npos);
}

TEST(Pcapng, WritesOneInterfacePerBus)
{
    const std::string file = written({traffic[0], traffic[0], traffic[1], traffic[0]});
    std::string types;
    for (const std::size_t at : blocks(file))
        types += std::to_string(static_cast<std::uint8_t>(file[at]));
    EXPECT_EQ(types, "10"
                     "16616"
                     "6");
}

} // namespace
} // namespace sinew::record
