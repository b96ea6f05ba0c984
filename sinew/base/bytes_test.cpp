#include "sinew/base/bytes.hpp"

#include <gtest/gtest.h>

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(Hex, ReadsBytesTogetherApartAndAsManualsPrintThem)
{
    EXPECT_EQ(from_hex("FFE0A0"), (Bytes{0xFF, 0xE0, 0xA0}));
    EXPECT_EQ(from_hex("ff e0\ta0\n"), (Bytes{0xFF, 0xE0, 0xA0}));
    EXPECT_EQ(from_hex("0xFF, 0xE0, 0xA"), (Bytes{0xFF, 0xE0, 0x0A}));
    EXPECT_EQ(from_hex("FF:E0"), (Bytes{0xFF, 0xE0}));
}

TEST(Hex, RefusesAnOddNumberOfDigitsAndNamesThem)
{
    for (const auto* text : {"FF E", "FFE", "0xFFE", "E"}) {
        const auto bytes = from_hex(text);
        ASSERT_FALSE(bytes.has_value()) << text;
        EXPECT_EQ(bytes.error().code, Errc::bad_hex);
        EXPECT_NE(to_sentence(bytes.error()).find("a byte takes two"), std::string::npos);
    }
}

TEST(Hex, RefusesWhatIsNoDigitAndNamesIt)
{
    const auto bytes = from_hex("FF G0");
    ASSERT_FALSE(bytes.has_value());
    EXPECT_NE(to_sentence(bytes.error()).find("'G'"), std::string::npos);
}

TEST(Hex, RefusesNothingAtAll)
{
    EXPECT_EQ(from_hex(" ").error().code, Errc::bad_hex);
}

TEST(Hex, PrintsWhatItReads)
{
    EXPECT_EQ(to_hex(Bytes{0xFF, 0x00, 0x7F}), "FF 00 7F");
    EXPECT_EQ(to_hex({}), "");
}

TEST(Integer, ReadsDecimalAndHexWithASign)
{
    EXPECT_EQ(to_integer("12"), 12);
    EXPECT_EQ(to_integer("-3"), -3);
    EXPECT_EQ(to_integer("0x1F"), 31);
}

TEST(Integer, RefusesAnythingElse)
{
    for (const auto* text : {"", "-", "0x", "12x", "1.5", "--1", " 1", "99999999999999999999"})
        EXPECT_EQ(to_integer(text).error().code, Errc::bad_argument) << text;
}

TEST(Nearest, SuggestsAWordThatIsCloseAndNothingElse)
{
    constexpr std::string_view names[] = {"set-pd-gain", "read-pd-gain", "ping"};
    EXPECT_EQ(nearest("set-pd-gian", names), "set-pd-gain");
    EXPECT_EQ(nearest("pong", names), "ping");
    EXPECT_EQ(nearest("zzzzzz", names), "");
    EXPECT_EQ(did_you_mean("pin", names), ", did you mean ping?");
    EXPECT_EQ(did_you_mean("zzzzzz", names), "");
}

TEST(Error, SaysWhichFieldIsOutsideWhichRange)
{
    const Error error{.code = Errc::out_of_range,
                      .message = "set-pd-gain",
                      .field = "p_gain",
                      .value = 255,
                      .low = 0,
                      .high = 254,
                      .id = 3};
    EXPECT_EQ(to_sentence(error), "set-pd-gain to id 3: p_gain is 255, which is outside 0 … 254");
}

TEST(Error, ShowsTheFirstBytesItSaw)
{
    Error error{.code = Errc::bad_checksum, .value = 0x4F, .low = 0x4E};
    keep_seen(error, Bytes(40, 0xAB));
    EXPECT_EQ(error.seen_size, 16);
    EXPECT_NE(to_sentence(error).find("(seen: AB AB"), std::string::npos);
}

TEST(Error, EveryCodeHasAWordOfItsOwn)
{
    for (int code = 0; code <= static_cast<int>(Errc::stopped); ++code) {
        EXPECT_NE(to_word(static_cast<Errc>(code)), "unknown") << code;
        for (int other = 0; other < code; ++other)
            EXPECT_NE(to_word(static_cast<Errc>(code)), to_word(static_cast<Errc>(other)));
    }
}

TEST(Time, BitTimesAreRoundedUp)
{
    EXPECT_EQ(bit_time(10, 1'500'000), Duration{6667});
    EXPECT_EQ(bit_time(10, 1'000'000), Duration{10'000});
}

} // namespace
} // namespace sinew
