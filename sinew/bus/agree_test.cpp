#include "sinew/bus/agree.hpp"

#include <gtest/gtest.h>

namespace sinew::bus {
namespace {

using wire::Coding;
using wire::Field;
using wire::Frame;
using wire::Kind;

/// Of `size` bytes with this one field.
bool agree(const Field& field, const Frame& first, const Frame& second)
{
    const wire::Side side{.size = first.size, .fields = std::span(&field, 1)};
    const bool one_way = bus::agree(side, first, second);
    EXPECT_EQ(bus::agree(side, second, first), one_way) << "it matters which of the two came first";
    return one_way;
}

bool agree(const Field& field, std::uint8_t first, std::uint8_t second)
{
    return agree(field, Frame{.size = 1, .data = {first}}, Frame{.size = 1, .data = {second}});
}

Frame pair(std::uint8_t first, std::uint8_t second)
{
    return {.size = 2, .data = {first, second}};
}

constexpr Field septets{.name = "septets", .bytes = 2, .top_bits = 7, .coding = Coding::septets};

TEST(Agree, AValueMayMoveByAThirtySecondOfWhatItsFieldAllowsEitherWay)
{
    const Field whole{.name = "whole"};
    EXPECT_TRUE(agree(whole, 100, 100));
    EXPECT_TRUE(agree(whole, 100, 108));
    EXPECT_FALSE(agree(whole, 100, 109));
    const Field narrow{.name = "narrow", .range = {100, 163}};
    EXPECT_TRUE(agree(narrow, 110, 112));
    EXPECT_FALSE(agree(narrow, 110, 113));
    const Field with_sign{.name = "with sign", .bytes = 2, .coding = Coding::i_le, .range = {-160, 159}};
    EXPECT_TRUE(agree(with_sign, pair(0xFB, 0xFF), pair(5, 0))) << "-5 and 5";
    EXPECT_FALSE(agree(with_sign, pair(0xFA, 0xFF), pair(5, 0))) << "-6 and 5";
}

TEST(Agree, AValueMayAlwaysMoveByOneUnlessItHasOneOrTwoBits)
{
    const Field three_bits{.name = "three bits", .msb = 2};
    EXPECT_TRUE(agree(three_bits, 3, 4));
    EXPECT_FALSE(agree(three_bits, 3, 5));
    const Field two_bits{.name = "two bits", .msb = 1};
    EXPECT_TRUE(agree(two_bits, 2, 2));
    EXPECT_FALSE(agree(two_bits, 2, 3));
    const Field five_values{.name = "five values", .range = {0, 4}};
    EXPECT_TRUE(agree(five_values, 2, 3));
}

TEST(Agree, WhatIsNoValueMustBeEqual)
{
    for (const Kind kind : {Kind::address, Kind::constant, Kind::opcode, Kind::reserved, Kind::size}) {
        EXPECT_TRUE(agree({.name = "fixed", .kind = kind}, 100, 100));
        EXPECT_FALSE(agree({.name = "fixed", .kind = kind}, 100, 101));
    }
    EXPECT_TRUE(agree({.name = "again", .kind = Kind::repeat}, 100, 108)) << "it moves with its value";
}

TEST(Agree, AChecksumIsNotComparedButTheFieldBehindItIs)
{
    const Field fields[] = {{.name = "checksum", .kind = Kind::checksum}, {.name = "value", .byte = 1}};
    const wire::Side side{.size = 2, .fields = fields};
    EXPECT_TRUE(bus::agree(side, pair(1, 100), pair(200, 101)));
    EXPECT_FALSE(bus::agree(side, pair(1, 100), pair(1, 200)));
}

TEST(Agree, FramesOfDifferentSizesDoNot)
{
    EXPECT_FALSE(agree(Field{.name = "value"}, Frame{.size = 1, .data = {5}}, pair(5, 5)));
}

TEST(Agree, AFrameThatCarriesNoValueWhereOneIsDueAgreesWithNone)
{
    EXPECT_TRUE(agree(septets, pair(1, 0x7F), pair(1, 0x7F)));
    EXPECT_FALSE(agree(septets, pair(1, 0x7F), pair(1, 0xFF))) << "bit 7 of a low byte is never set";
    EXPECT_FALSE(agree(septets, pair(1, 0xFF), pair(1, 0xFF))) << "equal, and both wrong";
}

} // namespace
} // namespace sinew::bus
