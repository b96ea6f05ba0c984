#include "sinew/wire/field.hpp"

#include <array>
#include <gtest/gtest.h>
#include <vector>

/// How a coding lies in bytes: the bytes of each case are written down by hand.
namespace sinew::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Case {
    Field field;
    std::int64_t value;
    Bytes bytes;
};

const std::vector<Case> cases{
    {{.byte = 1, .msb = 7, .lsb = 0}, 0xA7, {0, 0xA7, 0}},
    {{.byte = 1, .msb = 5, .lsb = 3}, 6, {0, 0x30, 0}},
    {{.byte = 0, .msb = 7, .lsb = 7}, 1, {0x80}},
    {{.byte = 0, .msb = 0, .lsb = 0}, 1, {0x01}},
    {{.byte = 1, .bytes = 2, .coding = Coding::u_le}, 0x1234, {0, 0x34, 0x12, 0}},
    {{.byte = 0, .bytes = 4, .coding = Coding::u_le}, 0xFEDCBA98, {0x98, 0xBA, 0xDC, 0xFE}},
    {{.byte = 0, .bytes = 6, .coding = Coding::u_le}, 0xFEDCBA987654, {0x54, 0x76, 0x98, 0xBA, 0xDC, 0xFE}},
    {{.byte = 1, .bytes = 1, .coding = Coding::i_le}, -1, {0, 0xFF, 0}},
    {{.byte = 0, .bytes = 1, .coding = Coding::i_le}, 127, {0x7F}},
    {{.byte = 0, .bytes = 2, .coding = Coding::i_le}, -2, {0xFE, 0xFF}},
    {{.byte = 0, .bytes = 2, .coding = Coding::i_le}, 0x0102, {0x02, 0x01}},
    {{.byte = 1, .bytes = 4, .coding = Coding::i_le}, -0x12345678, {0, 0x88, 0xA9, 0xCB, 0xED, 0}},
    {{.byte = 0, .bytes = 7, .coding = Coding::i_le}, -256, {0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}},
    {{.byte = 1, .bytes = 2, .coding = Coding::u_be}, 0x1234, {0, 0x12, 0x34, 0}},
    {{.byte = 0, .bytes = 3, .coding = Coding::u_be}, 0x010203, {0x01, 0x02, 0x03}},
    {{.byte = 1, .bytes = 2, .top_bits = 5, .coding = Coding::septets}, 0xFFF, {0, 0x1F, 0x7F, 0}},
    {{.byte = 0, .bytes = 2, .top_bits = 5, .coding = Coding::septets}, 0x081, {0x01, 0x01}},
    {{.byte = 0, .bytes = 3, .top_bits = 2, .coding = Coding::septets}, 0x4081, {0x01, 0x01, 0x01}},
    {{.byte = 1, .bytes = 2, .coding = Coding::signed_septets}, 0x3FFF, {0, 0x7F, 0x7F, 0}},
    {{.byte = 0, .bytes = 2, .coding = Coding::signed_septets}, -1, {0x80, 0x01}},
    {{.byte = 0, .bytes = 2, .coding = Coding::signed_septets}, -0x3FFF, {0xFF, 0x7F}},
    {{.byte = 0, .bytes = 2, .coding = Coding::signed_septets}, 0x81, {0x01, 0x01}},
    {{.byte = 0, .bytes = 2, .coding = Coding::signed_septets}, 0, {0x00, 0x00}},
};

TEST(Field, LiesInItsBytesAsTheCodingSays)
{
    for (const auto& c : cases) {
        Bytes bytes(c.bytes.size());
        put(c.field, c.value, bytes.data());
        EXPECT_EQ(bytes, c.bytes) << c.value;
        std::int64_t value = 99;
        EXPECT_TRUE(get(c.field, c.bytes.data(), value)) << c.value;
        EXPECT_EQ(value, c.value);
    }
}

TEST(Field, BitsLeaveTheirNeighboursAlone)
{
    const Field field{.msb = 4, .lsb = 2};
    std::uint8_t byte = 0xE3;
    put(field, 5, &byte);
    EXPECT_EQ(byte, 0xF7);
    std::int64_t value{};
    EXPECT_TRUE(get(field, &byte, value));
    EXPECT_EQ(value, 5);
}

TEST(Field, SeptetsShareTheirFirstByteWhereTheyAreToldTo)
{
    const Field shared{.bytes = 2, .top_bits = 4, .shares_top = true, .coding = Coding::septets};
    std::array<std::uint8_t, 2> data{0x90, 0};
    put(shared, 0x123, data.data());
    EXPECT_EQ(data, (std::array<std::uint8_t, 2>{0x92, 0x23}));
    std::int64_t value{};
    EXPECT_TRUE(get(shared, data.data(), value));
    EXPECT_EQ(value, 0x123);
}

TEST(Field, IsRefusedWhereABitIsSetThatItsCodingNeverSets)
{
    const Field septets{.bytes = 3, .top_bits = 4, .coding = Coding::septets};
    const Field signed_septets{.bytes = 2, .coding = Coding::signed_septets};
    std::int64_t value{};
    const auto is_read = [&](const Field& field, std::array<std::uint8_t, 3> data) {
        return get(field, data.data(), value);
    };
    EXPECT_TRUE(is_read(septets, {0x0F, 0x7F, 0x7F}));
    EXPECT_FALSE(is_read(septets, {0x10, 0, 0}));
    EXPECT_FALSE(is_read(septets, {0, 0x80, 0}));
    EXPECT_FALSE(is_read(septets, {0, 0, 0x80}));
    EXPECT_TRUE(is_read(signed_septets, {0xFF, 0x7F}));
    EXPECT_FALSE(is_read(signed_septets, {0, 0x80}));
}

TEST(Field, ALenientReceiverMasksBit7OfOneByte)
{
    const Field field{.bytes = 3, .top_bits = 4, .lenient = 1, .coding = Coding::septets};
    std::int64_t value{};
    const std::array<std::uint8_t, 3> masked{0x01, 0x82, 0x03};
    EXPECT_TRUE(get(field, masked.data(), value));
    EXPECT_EQ(value, (1 << 14) + (2 << 7) + 3);
    const std::array<std::uint8_t, 3> other{0x01, 0x02, 0x83};
    EXPECT_FALSE(get(field, other.data(), value));
}

TEST(Field, CarriesAsMuchAsItsBitsHold)
{
    EXPECT_EQ(capacity({.msb = 7, .lsb = 0}), (Range{0, 255}));
    EXPECT_EQ(capacity({.msb = 4, .lsb = 2}), (Range{0, 7}));
    EXPECT_EQ(capacity({.bytes = 2, .coding = Coding::u_le}), (Range{0, 65535}));
    EXPECT_EQ(capacity({.bytes = 6, .coding = Coding::u_le}), (Range{0, 281'474'976'710'655}));
    EXPECT_EQ(capacity({.bytes = 3, .coding = Coding::u_be}), (Range{0, 16'777'215}));
    EXPECT_EQ(capacity({.bytes = 1, .coding = Coding::i_le}), (Range{-128, 127}));
    EXPECT_EQ(capacity({.bytes = 4, .coding = Coding::i_le}), (Range{-2'147'483'648, 2'147'483'647}));
    EXPECT_EQ(capacity({.bytes = 3, .top_bits = 2, .coding = Coding::septets}), (Range{0, 65535}));
    EXPECT_EQ(capacity({.bytes = 2, .coding = Coding::signed_septets}), (Range{-16383, 16383}));
}

TEST(Field, AllowsWhatIsPrintedOrElseAllThatItCarries)
{
    EXPECT_EQ(allowed({.range = {-3, 4}}), (Range{-3, 4}));
    EXPECT_EQ(allowed({.msb = 1, .lsb = 0}), (Range{0, 3}));
    EXPECT_FALSE(Range{}.given());
    EXPECT_TRUE((Range{0, 0}.given()));
}

TEST(Range, ContainsBothOfItsEnds)
{
    const Range range{-2, 5};
    EXPECT_TRUE(range.contains(-2));
    EXPECT_TRUE(range.contains(5));
    EXPECT_FALSE(range.contains(-3));
    EXPECT_FALSE(range.contains(6));
}

TEST(Field, ExplainsTheBitsThatAreItsOwn)
{
    const Field bits{.byte = 2, .msb = 4, .lsb = 2};
    EXPECT_EQ(claimed(bits, 1), 0);
    EXPECT_EQ(claimed(bits, 2), 0x1C);
    EXPECT_EQ(claimed(bits, 3), 0);
    EXPECT_EQ(claimed({.byte = 2}, 2), 0xFF);

    Field septets{.byte = 1, .bytes = 2, .top_bits = 4, .shares_top = true, .coding = Coding::septets};
    EXPECT_EQ(claimed(septets, 0), 0);
    EXPECT_EQ(claimed(septets, 1), 0x0F);
    EXPECT_EQ(claimed(septets, 2), 0xFF);
    EXPECT_EQ(claimed(septets, 3), 0);
    septets.shares_top = false;
    EXPECT_EQ(claimed(septets, 1), 0xFF) << "the bits above must be clear, so they are its own";
    // Where the whole byte is one value, `shares_top` says nothing.
    const Field word{.byte = 1, .bytes = 2, .shares_top = true, .coding = Coding::u_le};
    EXPECT_EQ(claimed(word, 1), 0xFF);
    EXPECT_EQ(claimed(word, 2), 0xFF);
}

TEST(Options, AFieldAppliesWhileItsBitsStandAsTheyShould)
{
    constexpr std::uint32_t one = 1, four = 4;
    EXPECT_TRUE(When{}.holds({}));
    EXPECT_TRUE(When{}.holds({.bits = 7}));
    const When set{four, four}, clear{four, 0};
    EXPECT_TRUE(set.holds({.bits = four | one}));
    EXPECT_FALSE(set.holds({.bits = one}));
    EXPECT_TRUE(clear.holds({.bits = one}));
    EXPECT_FALSE(clear.holds({.bits = four}));
    EXPECT_TRUE((Options{.bits = four}.has(four)));
    EXPECT_FALSE((Options{.bits = four}.has(one)));
}

} // namespace
} // namespace sinew::wire
