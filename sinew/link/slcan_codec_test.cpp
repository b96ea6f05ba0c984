#include "sinew/link/slcan_codec.hpp"

#include "sinew/link/link_test_support.hpp"

#include <random>
#include <vector>

namespace sinew::link::slcan {
namespace {

std::string encoded(const wire::Frame& frame)
{
    std::array<std::uint8_t, longest_frame_text> text;
    const std::size_t size = encode(frame, text);
    return {text.begin(), text.begin() + size};
}

std::vector<Reader::End> ends(Reader& reader, std::string_view text)
{
    std::vector<Reader::End> all;
    for (const std::uint8_t byte : test::bytes(text))
        if (const auto end = reader.take(byte); end != Reader::End::none)
            all.push_back(end);
    return all;
}

TEST(SlcanCodec, WritesFramesAsTheManualHasThem)
{
    EXPECT_EQ(encoded({.can_id = 0x100, .size = 2, .data = {0x11, 0x33}}), "t10021133\r");
    EXPECT_EQ(encoded({.can_id = 0x7FF, .size = 0}), "t7FF0\r");
    EXPECT_EQ(encoded({.can_id = 0x141, .size = 8, .data = {0x9A, 1, 2, 3, 4, 5, 6, 0xFF}}), "t14189A010203040506FF\r");
}

TEST(SlcanCodec, WritesNothingThatIsNoFrameOfCan)
{
    EXPECT_EQ(encoded({.can_id = 0x800, .size = 0}), "");
    EXPECT_EQ(encoded({.can_id = 0x001, .size = 9}), "");
}

TEST(SlcanCodec, ReadsBackEveryFrame)
{
    const unsigned seed = std::random_device{}();
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random{seed};
    for (int i = 0; i < 10'000; ++i) {
        wire::Frame frame{.can_id = static_cast<std::uint32_t>(random() % 0x800),
                          .size = static_cast<std::uint8_t>(random() % 9)};
        for (std::size_t k = 0; k < frame.size; ++k)
            frame.data[k] = static_cast<std::uint8_t>(random());
        std::string text = encoded(frame);
        text.pop_back();
        if (random() % 2 == 0)
            text += "1A2b"; // a time stamp
        const Line line = decode(text);
        ASSERT_EQ(line.kind, Kind::frame) << text;
        ASSERT_EQ(line.frame, frame) << text;
    }
}

TEST(SlcanCodec, TakesSmallDigitsToo)
{
    EXPECT_EQ(decode("t1aB1fF").frame, (wire::Frame{.can_id = 0x1AB, .size = 1, .data = {0xFF}}));
}

TEST(SlcanCodec, TellsForeignFramesFromBrokenOnes)
{
    for (const auto* text : {"T1FFFFFFF2AABB", "T000000010", "r7FF8", "R1FFFFFFF0", "T1FFFFFFF2AABB1234", "r14101234"})
        EXPECT_EQ(decode(text).kind, Kind::foreign) << text;
    for (const auto* text :
         {"t", "t1", "t100", "t8000", "t1009", "t1002AA", "t1002AABBC", "t1002AABBCC", "t1002AAGB", "tX002AABB",
          "t100XAABB", "t1000123", "t1000123G", "T2000000000", "T1FFFFFFF", "r10081", "t1002AABB12345"})
        EXPECT_EQ(decode(text).kind, Kind::malformed) << text;
    for (const auto* text : {"", "z", "Z", "V1013", "F00", "NA123", "S8"})
        EXPECT_EQ(decode(text).kind, Kind::other) << text;
}

TEST(SlcanCodec, KnowsTheNineRates)
{
    EXPECT_EQ(code_of(10'000), '0');
    EXPECT_EQ(code_of(500'000), '6');
    EXPECT_EQ(code_of(1'000'000), '8');
    EXPECT_EQ(code_of(333'000), std::nullopt);
    EXPECT_EQ(code_of(0), std::nullopt);
}

TEST(SlcanReader, EndsLinesAtCrAndAtBel)
{
    Reader reader;
    EXPECT_EQ(ends(reader, "t1000\r"), std::vector{Reader::End::line});
    EXPECT_EQ(reader.text(), "t1000");
    EXPECT_EQ(ends(reader, "\a"), std::vector{Reader::End::refused});
    EXPECT_EQ(reader.text(), "");
    EXPECT_EQ(ends(reader, "z\r\r"), (std::vector{Reader::End::line, Reader::End::line}));
    EXPECT_EQ(reader.text(), "");
    EXPECT_EQ(ends(reader, "\nV1013\r"), std::vector{Reader::End::line});
    EXPECT_EQ(reader.text(), "V1013") << "the LF belongs to the line before";
}

TEST(SlcanReader, SwallowsALineThatIsTooLongAndGoesOn)
{
    Reader reader;
    EXPECT_EQ(ends(reader, std::string(1000, 't') + "\r"), std::vector{Reader::End::overlong});
    EXPECT_EQ(reader.text(), "");
    EXPECT_EQ(ends(reader, "t1000\r"), std::vector{Reader::End::line});
    EXPECT_EQ(reader.text(), "t1000");
}

} // namespace
} // namespace sinew::link::slcan
