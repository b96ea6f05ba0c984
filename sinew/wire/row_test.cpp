#include "sinew/wire/fake_messages.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <vector>

/// What is made of rows: sides, selections and checksums, and which rows stop the compiler.
namespace sinew::wire {
namespace {

TEST(Sum, OfAnyNumberOfBytesIsTheirSum)
{
    for (std::size_t size = 0; size <= 64; ++size)
        for (const unsigned step : {0U, 1U, 37U}) {
            // With a byte before and behind that must not count.
            std::vector<std::uint8_t> bytes(size + 2, 0xFF);
            for (std::size_t i = 0; i < size; ++i)
                bytes[i + 1] = static_cast<std::uint8_t>(0xFF - step * i);
            EXPECT_EQ(sum_of(bytes.data() + 1, size), std::accumulate(bytes.begin() + 1, bytes.end() - 1, 0U))
                << size << " bytes";
        }
}

TEST(Sum, IsTheSameAtCompileTime)
{
    constexpr std::array<std::uint8_t, 9> nine{1, 2, 3, 4, 5, 6, 7, 8, 255};
    constexpr unsigned sum = sum_of(nine.data(), nine.size());
    EXPECT_EQ(sum, 291U);
}

TEST(Checksum, Xor7LeavesTheHeaderAndItselfOut)
{
    const std::array<std::uint8_t, 5> frame{0xFF, 0x81, 0x42, 0x27, 0x55};
    EXPECT_EQ(checksum(Checksum::xor7, frame.data(), frame.size()), 0x64); // 81 ^ 42 ^ 27 = E4
}

TEST(Checksum, NotSumLeavesTheHeaderAndItselfOut)
{
    const std::array<std::uint8_t, 8> frame{0xFF, 0xFE, 0x01, 0x04, 0x99, 0x0A, 0x10, 0xE0};
    EXPECT_EQ(checksum(Checksum::not_sum, frame.data(), frame.size()), 0x00); // 01 + 04 + 0A + 10 + E0 = FF
    const std::array<std::uint8_t, 6> shortest{0xFF, 0xFE, 0x00, 0x02, 0x99, 0xD0};
    EXPECT_EQ(checksum(Checksum::not_sum, shortest.data(), shortest.size()), 0x2D); // 02 + D0 = D2
}

TEST(Checksum, StandsWhereItsFieldSaysOrAtTheEnd)
{
    EXPECT_EQ(checksum_byte(fake::summed, 9), 4);
    EXPECT_EQ(checksum_byte(fake::crossed, 5), 4);
    EXPECT_EQ(checksum_byte(fake::crossed, 11), 10);
    EXPECT_EQ(checksum_byte(fake::bare, 2), -1);
}

std::vector<std::string_view> names(const Side& side)
{
    std::vector<std::string_view> out;
    for (const Field& f : side.fields)
        out.push_back(f.name);
    return out;
}

TEST(Side, HasTheFieldsOfItsLayoutFirst)
{
    const MessageInfo& far = info_of<fake::Far>;
    EXPECT_EQ(names(far.request), (std::vector<std::string_view>{"header", "second_header", "id", "size", "sum",
                                                                 "opcode", "value", "value_again", "tail"}));
    EXPECT_EQ(far.request.fields[5].fixed, 0x12);
    EXPECT_EQ(far.request.fields[3].fixed, 5) << "bytes behind the size";
    EXPECT_EQ(far.request.size, 9);
    EXPECT_TRUE(far.request.exists());
    EXPECT_FALSE(far.reply.exists());
    EXPECT_EQ(&far.side(Direction::request), &far.request);
    EXPECT_EQ(&far.side(Direction::reply), &far.reply);
}

TEST(Side, KnowsItsOpcodes)
{
    const MessageInfo& whole = info_of<fake::Whole>;
    EXPECT_EQ(whole.request.opcode, 0x11);
    EXPECT_EQ(whole.reply.opcode, 0x91);
    EXPECT_EQ(whole.reply.fields[5].fixed, 0x91);
    EXPECT_EQ(whole.reply.opcode_also, -1);

    const MessageInfo& edges = info_of<fake::Edges>;
    EXPECT_EQ(edges.reply.opcode, 0x76) << "as the request";
    EXPECT_EQ(edges.request.opcode_also, -1);
    EXPECT_EQ(edges.request.also_when, 0U);
    EXPECT_EQ(edges.reply.opcode_also, 0);
    EXPECT_EQ(edges.reply.also_when, fake::other_answer);
}

TEST(Side, NamesTheFieldThatSaysWhichDeviceItIs)
{
    ASSERT_NE(info_of<fake::Whole>.reply.device, nullptr);
    EXPECT_EQ(info_of<fake::Whole>.reply.device->kind, Kind::address);
    EXPECT_EQ(info_of<fake::Parameter>.request.device, nullptr);
}

TEST(Side, AChecksumAtTheEndStandsInItsLastByte)
{
    EXPECT_EQ(info_of<fake::Look>.request.fields[4].byte, 3);
    EXPECT_EQ(info_of<fake::Steps>.request.fields[4].byte, 5);
}

std::array<std::uint8_t, 8> bytes_of(std::uint64_t word)
{
    return std::bit_cast<std::array<std::uint8_t, 8>>(word);
}

TEST(Selection, IsMadeOfConstantsOpcodeAndSize)
{
    using Eight = std::array<std::uint8_t, 8>;
    const Selection whole = info_of<fake::Whole>.request.selection;
    EXPECT_TRUE(whole.is_all);
    EXPECT_EQ(bytes_of(whole.mask), (Eight{0xFF, 0xFF, 0, 0xFF, 0, 0xFF, 0, 0}));
    EXPECT_EQ(bytes_of(whole.value), (Eight{0xA5, 0x5A, 0, 0x14, 0, 0x11, 0, 0}));
    const Selection look = info_of<fake::Look>.request.selection;
    EXPECT_TRUE(look.is_all);
    EXPECT_EQ(bytes_of(look.mask), (Eight{0xFF, 0xE0, 0xFF})) << "of a byte only the bits that are constant";
    EXPECT_EQ(bytes_of(look.value), (Eight{0xFF, 0xA0, 0x22}));
}

TEST(Selection, IsNotAllWhereOtherBytesOpcodesOrSizesTellAsWell)
{
    EXPECT_FALSE(info_of<fake::Far>.request.selection.is_all) << "a constant in the ninth byte";
    EXPECT_FALSE(info_of<fake::Steps>.request.selection.is_all) << "of many sizes";
    EXPECT_TRUE(info_of<fake::Edges>.request.selection.is_all);
    EXPECT_FALSE(info_of<fake::Edges>.reply.selection.is_all) << "two opcodes";
}

inline constexpr Field eighth[] = {{.name = "rest", .bytes = 7, .coding = Coding::u_le}, constant("last", 7, 3)};

TEST(Selection, HoldsAConstantInTheEighthByte)
{
    constexpr Selection selection = selection_of(Side{.layout = &fake::bare, .size = 8, .fields = eighth});
    EXPECT_TRUE(selection.is_all);
    EXPECT_EQ(bytes_of(selection.mask), (std::array<std::uint8_t, 8>{0, 0, 0, 0, 0, 0, 0, 0xFF}));
    EXPECT_EQ(bytes_of(selection.value), (std::array<std::uint8_t, 8>{0, 0, 0, 0, 0, 0, 0, 3}));
}

// ---- what stops the compiler ----

template <std::uint8_t Size, auto Fields>
consteval bool checked()
{
    constexpr auto fields = Fields();
    check_side({.layout = &fake::bare, .size = Size, .fields = fields});
    return true;
}

/// A side of so many bytes with these fields stops the compiler.
template <std::uint8_t Size, auto Fields>
concept is_refused = !requires { typename std::bool_constant<checked<Size, Fields>()>; };

#define FIELDS(...) [] { return std::to_array<Field>(__VA_ARGS__); }

TEST(Row, IsGoodWhereEveryBitIsExplainedOnce)
{
    EXPECT_FALSE((is_refused<2, FIELDS({{.name = "a"}, {.name = "b", .byte = 1}})>));
    EXPECT_FALSE((is_refused<1, FIELDS({{.name = "a", .msb = 7, .lsb = 3}, {.name = "b", .msb = 2, .lsb = 0}})>));
    EXPECT_FALSE((is_refused<2, FIELDS({{.name = "a"}, {.name = "sum", .from_end = true}})>));
    EXPECT_FALSE((is_refused<1, FIELDS({{.name = "a"}, {.name = "more", .byte = 1, .kind = Kind::sequence}})>));
}

TEST(Row, IsRefusedWhereABitIsExplainedTwiceOrNot)
{
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .msb = 7, .lsb = 3}, {.name = "b", .msb = 3, .lsb = 0}})>));
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a"}, {.name = "b", .byte = 1}, {.name = "c", .byte = 1}})>));
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a"}, {.name = "b", .byte = 1}, {.name = "c", .from_end = true}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .msb = 7, .lsb = 1}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .msb = 6, .lsb = 0}})>));
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a", .byte = 1}})>));
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a"}})>));
}

TEST(Row, IsRefusedWhereAFieldLiesOutsideTheFrame)
{
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a"}, {.name = "b", .byte = 1}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .bytes = 2, .coding = Coding::u_le}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .msb = 8}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a"}, {.name = "b", .msb = 3, .lsb = 4}})>));
    EXPECT_FALSE(
        (is_refused<24, FIELDS({{.name = "a", .bytes = 24, .coding = Coding::signed_septets, .range = {0, 0}}})>));
    EXPECT_TRUE(
        (is_refused<25, FIELDS({{.name = "a", .bytes = 25, .coding = Coding::signed_septets, .range = {0, 0}}})>));
}

TEST(Row, IsRefusedWhereARangeDoesNotFitTheCoding)
{
    EXPECT_FALSE((is_refused<1, FIELDS({{.name = "a", .range = {0, 255}, .recommended = {255, 255}}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .range = {0, 256}}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .range = {-1, 255}}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .range = {4, 3}}})>));
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .recommended = {0, 256}}})>));
}

TEST(Row, IsRefusedWhereTwoFieldsHaveOneNameUnlessTheyNeverApplyTogether)
{
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a"}, {.name = "a", .byte = 1}})>));
    EXPECT_FALSE((is_refused<1, FIELDS({{.name = "a", .when = {1, 0}}, {.name = "a", .when = {1, 1}}})>));
    EXPECT_TRUE((is_refused<2, FIELDS({{.name = "a", .when = {1, 0}},
                                       {.name = "a", .byte = 1, .when = {1, 0}},
                                       {.name = "b", .bytes = 2, .coding = Coding::u_le, .when = {1, 1}}})>));
}

TEST(Row, EveryBitIsExplainedWhateverTheOptionsAre)
{
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .when = {1, 0}}})>)) << "while the option is set";
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .when = {1, 1}}})>)) << "while it is not";
    EXPECT_TRUE((is_refused<1, FIELDS({{.name = "a", .when = {1, 0}}, {.name = "b"}})>));
    EXPECT_FALSE((is_refused<1, FIELDS({{.name = "a", .when = {6, 0}}, {.name = "b", .when = {6, 6}}})>));
}

#undef FIELDS

template <std::size_t Tag>
struct Plain {
};
constexpr std::string_view plain_names[] = {"one", "two", "one", "four", "five", "six"};
constexpr int plain_opcodes[] = {1, 2, 3, 2, -1, -1};
template <std::size_t Tag>
consteval auto row_of(const Plain<Tag>*)
{
    return message<Plain<Tag>, Nothing>({.name = plain_names[Tag], .opcode = plain_opcodes[Tag], .reply_opcode = 0},
                                        side<Plain<Tag>>(fake::bare, 1, reserved("free", 0)), no_side);
}

template <class... Messages>
concept is_catalogue = requires { typename std::bool_constant<(catalogue<Messages...>(), true)>; };

TEST(Catalogue, IsRefusedWhereTwoMessagesHaveOneNameOrOpcode)
{
    EXPECT_TRUE((is_catalogue<Plain<0>, Plain<1>>));
    EXPECT_FALSE((is_catalogue<Plain<0>, Plain<1>, Plain<2>>)) << "one name";
    EXPECT_FALSE((is_catalogue<Plain<0>, Plain<1>, Plain<3>>)) << "one opcode";
    EXPECT_FALSE((is_catalogue<Plain<1>, Plain<1>>));
    EXPECT_TRUE((is_catalogue<Plain<0>, Plain<4>, Plain<5>>)) << "none is no opcode";
}

TEST(Message, IsAHarmlessReadOfOneDeviceUnlessItsRowSaysOtherwise)
{
    const Info& look = info_of<fake::Look>.info;
    EXPECT_EQ(look.access, Access::read);
    EXPECT_EQ(look.reply_opcode_also, -1) << "none";
    EXPECT_EQ(std::pair(Info{}.opcode, Info{}.reply_opcode), std::pair(-1, -1)) << "none";
    EXPECT_FALSE(look.moves);
    EXPECT_FALSE(look.relative);
    EXPECT_FALSE(look.answered_as_command);
    EXPECT_FALSE(look.broadcast);
    EXPECT_EQ(info_of<fake::Steps>.info.access, Access::flash);
    EXPECT_TRUE(info_of<fake::Steps>.info.broadcast);
}

TEST(Side, AnOpcodeMayBeZero)
{
    EXPECT_EQ(row<Plain<0>>.info.reply_opcode, 0);
    EXPECT_EQ(row<fake::Look>.info.reply_opcode, 0x22) << "as the request where none is said";
}

TEST(Catalogue, HoldsItsMessagesInTheirOrder)
{
    ASSERT_EQ(fake::all_messages.size(), 7U);
    EXPECT_EQ(fake::all_messages[0], &info_of<fake::Whole>);
    EXPECT_EQ(fake::all_messages[6]->name(), "everybody");
}

// ---- how fields are written down ----

struct Members {
    std::uint8_t value{};
    std::int64_t wide{};
};

TEST(Field, IsBuiltWithTheCodingItsNameSays)
{
    constexpr auto of = [](auto bound) { return std::pair(bound.field.coding, int{bound.field.bytes}); };
    constexpr auto wide = &Members::wide;
    EXPECT_EQ(of(i8(wide, {})), (std::pair(Coding::i_le, 1)));
    EXPECT_EQ(of(u16_le(wide, {})), (std::pair(Coding::u_le, 2)));
    EXPECT_EQ(of(i16_le(wide, {})), (std::pair(Coding::i_le, 2)));
    EXPECT_EQ(of(u32_le(wide, {})), (std::pair(Coding::u_le, 4)));
    EXPECT_EQ(of(i32_le(wide, {})), (std::pair(Coding::i_le, 4)));
    EXPECT_EQ(of(u48_le(wide, {})), (std::pair(Coding::u_le, 6)));
    EXPECT_EQ(of(i56_le(wide, {})), (std::pair(Coding::i_le, 7)));
    EXPECT_EQ(of(u16_be(wide, {})), (std::pair(Coding::u_be, 2)));
    EXPECT_EQ(of(signed_septets(wide, {})), (std::pair(Coding::signed_septets, 2)));
    constexpr Field seven = septets(wide, 4, 3, {.byte = 2}).field;
    EXPECT_EQ(seven.top_bits, 4);
    EXPECT_EQ(seven.bytes, 3);
    EXPECT_EQ(seven.byte, 2);
    constexpr Field some = bits(&Members::value, 6, 2, {.byte = 3}).field;
    EXPECT_EQ(some.msb, 6);
    EXPECT_EQ(some.lsb, 2);
    EXPECT_EQ(some.bytes, 1);
}

TEST(Field, WithoutAMemberSaysWhatStandsThere)
{
    constexpr Field fixed = constant_bits("mode", 1, 7, 5, 6);
    EXPECT_EQ(fixed.kind, Kind::constant);
    EXPECT_EQ(std::tuple(fixed.byte, fixed.msb, fixed.lsb, fixed.fixed), std::tuple(1, 7, 5, 6));
    constexpr Field free = reserved("free", 4);
    EXPECT_EQ(free.kind, Kind::reserved);
    EXPECT_EQ(std::tuple(free.byte, free.msb, free.lsb, free.fixed), std::tuple(4, 7, 0, 0));
    constexpr Field twice = repeat("again", 5, 3);
    EXPECT_EQ(twice.kind, Kind::repeat);
    EXPECT_EQ(std::tuple(twice.byte, twice.source), std::tuple(5, 3));
}

} // namespace
} // namespace sinew::wire
