#include "sinew/record/candump.hpp"

#include <gtest/gtest.h>

namespace sinew::record {
namespace {

using wire::Direction;
using namespace std::chrono_literals;

std::span<const std::uint8_t> bytes_of(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

struct Read {
    std::vector<Captured> frames;
    std::vector<std::string> errors;
};

Read read(std::string_view text, std::size_t piece = 4096)
{
    CandumpReader reader;
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
        reader.feed(bytes_of(text.substr(at, piece)));
        drain();
    }
    reader.end();
    drain();
    return out;
}

std::string written(const Captured& captured)
{
    std::string out;
    CandumpWriter writer;
    EXPECT_TRUE(writer.add(captured, out));
    return out;
}

const Captured status{.at = Time{1436509052249713us},
                      .bus = "can0",
                      .direction = Direction::request,
                      .kind = Captured::Kind::can,
                      .frame = {.can_id = 0x141, .size = 8, .data = {0x9A}}};
constexpr std::string_view status_line = "(1436509052.249713) can0 141#9A00000000000000 T\n";

TEST(Candump, WritesALineAsCandumpDoes)
{
    EXPECT_EQ(written(status), status_line);
    Captured heard = status;
    heard.direction = Direction::reply;
    EXPECT_EQ(written(heard), "(1436509052.249713) can0 141#9A00000000000000 R\n");
    heard.direction.reset();
    EXPECT_EQ(written(heard), "(1436509052.249713) can0 141#9A00000000000000\n");
}

TEST(Candump, ReadsInPiecesOfAnySizeWhatItWrote)
{
    const std::string text = std::string(status_line) + written(status);
    for (std::size_t piece = 1; piece <= text.size(); ++piece)
        EXPECT_EQ(read(text, piece).frames, (std::vector{status, status})) << piece;
}

TEST(Candump, ReadsNanosecondsAndNoFraction)
{
    EXPECT_EQ(read("(1.000000001) can0 141#\n").frames[0].at, Time{1000000001ns});
    EXPECT_EQ(read("(12.5) can0 141#\n").frames[0].at, Time{12500ms});
    EXPECT_EQ(read("(7) can0 141#\n").frames[0].at, Time{7s});
}

TEST(Candump, KeepsFramesThatNoFamilyUses)
{
    for (const std::string_view line : {"(1.000000) can0 00000141#01\n", "(1.000000) can0 12345678#R\n",
                                        "(1.000000) can0 141#R8\n", "(1.000000) can0 20000004#0010000000000000\n"}) {
        const auto got = read(line);
        ASSERT_EQ(got.frames.size(), 1U) << line;
        EXPECT_EQ(written(got.frames[0]), line);
    }
    EXPECT_EQ(read("(1.0) can0 20000004#00\n").frames[0].kind, Captured::Kind::can_error);
    EXPECT_TRUE(read("(1.0) can0 00000141#00\n").frames[0].extended);
}

TEST(Candump, GoesOnAfterALineThatIsWrongAndSaysWhichAndWhy)
{
    const auto got = read("# a log\n\nnonsense\n(1.0) can0\n(1.0) can0 141#0\n(1.0) can0 141##0AA\n(1.0) can0 9XX#00\n"
                          "(1.0) can0 141#00 X\n(1.0) can0 141#00 R more\n(1.x) can0 141#00\n" +
                          std::string(status_line));
    EXPECT_EQ(got.frames, std::vector{status});
    ASSERT_EQ(got.errors.size(), 8U);
    const std::string_view expected[] = {"line 3: 'nonsense' is no time",
                                         "line 4: a line has a time, a bus and",
                                         "line 5: ",
                                         "line 6: '141##0AA' is a CAN FD frame",
                                         "line 7: '9XX' is no CAN",
                                         "line 8: 'X' is neither R nor T",
                                         "line 9: 'more' follows the frame",
                                         "line 10: '(1.x)' is no time"};
    for (std::size_t i = 0; i < got.errors.size(); ++i)
        EXPECT_TRUE(got.errors[i].starts_with(expected[i])) << got.errors[i];
}

TEST(Candump, GivesAllBeforeTheCutOfATruncatedFileAndSaysSo)
{
    const std::string text = std::string(status_line) + written(status);
    for (std::size_t cut = status_line.size() + 1; cut < text.size(); ++cut) {
        const auto got = read(std::string_view(text).substr(0, cut));
        EXPECT_EQ(got.frames, std::vector{status}) << cut;
        ASSERT_EQ(got.errors.size(), 1U) << cut;
        EXPECT_EQ(got.errors[0], "line 2: the file ends inside this line; all before it was read");
    }
}

TEST(Candump, HoldsNoMoreThanALineOfEndlessGarbage)
{
    const std::string garbage(100'000, 'x');
    const auto got = read(garbage + "\n" + std::string(status_line), 1000);
    EXPECT_EQ(got.frames, std::vector{status});
    EXPECT_EQ(got.errors, std::vector<std::string>{"line 1: it is too long for a log of candump"});
    EXPECT_EQ(read(garbage, 1000).errors.size(), 1U);
}

TEST(Candump, RefusesBytesOfASerialLine)
{
    std::string out;
    CandumpWriter writer;
    const auto added = writer.add({.bytes = {1, 2}}, out);
    ASSERT_FALSE(added);
    EXPECT_NE(added.error().detail.find(".pcapng"), std::string::npos);
    EXPECT_EQ(out, "");
}

TEST(Candump, WritesABusWithBlanksAsOneWord)
{
    Captured odd = status;
    odd.bus = "left arm";
    EXPECT_EQ(read(written(odd)).frames[0].bus, "left_arm");
}

} // namespace
} // namespace sinew::record
