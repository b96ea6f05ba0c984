#include "apps/cli/capture.hpp"

#include <gtest/gtest.h>

namespace sinew::cli {
namespace {

wire::Frame frame_of(std::string_view line)
{
    const auto captured = parse_capture(line);
    EXPECT_TRUE(captured.has_value()) << line << ": " << (captured ? "" : to_sentence(captured.error()));
    return captured && captured->is_can() ? captured->frame : wire::Frame{};
}

constexpr wire::Frame speed{.can_id = 0x141, .size = 8, .data = {0xA2, 0, 0, 0, 0x28, 0x23, 0, 0}};

TEST(Capture, ReadsWhatCandumpPrints)
{
    EXPECT_EQ(frame_of("  can0  141   [8]  A2 00 00 00 28 23 00 00"), speed);
    EXPECT_EQ(frame_of(" (000.000123)  can0  141   [8]  A2 00 00 00 28 23 00 00   '....(#..'"), speed);
    EXPECT_EQ(frame_of("can0  RX - -  141   [8]  A2 00 00 00 28 23 00 00"), speed);
}

TEST(Capture, ReadsWhatCandumpLogs)
{
    EXPECT_EQ(frame_of("(1436509052.249713) can0 141#A200000028230000"), speed);
    EXPECT_EQ(frame_of("(1436509052.249713) can0 141#A200000028230000 R"), speed);
    EXPECT_EQ(frame_of("141#A2.00.00.00.28.23.00.00"), speed);
}

TEST(Capture, ReadsBytesInHex)
{
    const auto captured = parse_capture("FF e0 0xC2 01");
    ASSERT_TRUE(captured.has_value());
    EXPECT_EQ(captured->bytes, (std::vector<std::uint8_t>{0xFF, 0xE0, 0xC2, 1}));
}

TEST(Capture, RefusesWithTheReason)
{
    const auto why = [](std::string_view line) {
        const auto captured = parse_capture(line);
        EXPECT_FALSE(captured.has_value()) << line;
        EXPECT_EQ(captured ? Errc{} : captured.error().code, Errc::bad_hex) << line;
        return captured ? std::string{} : captured.error().detail;
    };
    EXPECT_NE(why("FF XX").find("'X'"), std::string::npos);
    EXPECT_NE(why("FFE").find("3 hex digits"), std::string::npos);
    EXPECT_NE(why("can0 141 [8] A2 00").find("2 bytes follow where [8] says 8"), std::string::npos);
    EXPECT_NE(why("141##0AABB").find("CAN FD"), std::string::npos);
    EXPECT_NE(why("141#R").find("remote"), std::string::npos);
    EXPECT_NE(why("12345678#00").find("29 bits"), std::string::npos);
    EXPECT_NE(why("[8] 00").find("no CAN identifier"), std::string::npos);
}

TEST(Capture, PassesOverCommentsAndEmptyLines)
{
    const auto lines = lines_of("# a log\n\n  141#00 \n; more\nFF\n");
    ASSERT_EQ(lines.size(), 2U);
    EXPECT_EQ(lines[0].number, 3U);
    EXPECT_EQ(lines[0].text, "141#00");
    EXPECT_EQ(lines[1].number, 5U);
}

} // namespace
} // namespace sinew::cli
