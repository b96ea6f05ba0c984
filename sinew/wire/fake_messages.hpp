#pragma once
#include "sinew/wire/message.hpp"

/// Messages for the tests of this room, so that they stand on no real family: between them every coding, every kind of
/// field, both checksums and both kinds of CAN identifier.
namespace sinew::wire::fake {

// ---- serial lines: `A5 5A id size sum opcode values …` ----

inline constexpr Field summed_fields[] = {constant("header", 0, 0xA5),
                                          constant("second_header", 1, 0x5A),
                                          {.name = "id", .byte = 2, .kind = Kind::address, .range = {0, 9}},
                                          {.name = "size", .byte = 3, .kind = Kind::size},
                                          {.name = "sum", .byte = 4, .kind = Kind::checksum},
                                          {.name = "opcode", .byte = 5, .kind = Kind::opcode}};
inline constexpr Layout summed{.name = "summed", .checksum = Checksum::not_sum, .fields = summed_fields, .ids = {0, 9}};

/// As long as a frame can be.
struct Whole {
    std::uint8_t byte{};
    std::int8_t signed_byte{};
    std::uint16_t low_first{};
    std::int16_t signed_low_first{};
    std::uint16_t high_first{};
    std::int32_t degrees{};
    std::int64_t six{};
};
enum class Mode : std::uint8_t { off, slow, fast };
inline constexpr Label modes[] = {{0, "off"}, {1, "slow"}, {2, "fast"}};
struct Packed {
    std::uint32_t low_first{};
    std::int64_t seven{};
    Mode mode{};
    bool is_hot{};
    std::uint16_t septets{};
    std::int16_t signed_septets{};
};
consteval auto row_of(const Whole*)
{
    return message<Whole, Packed>(
        {.name = "whole", .opcode = 0x11, .reply_opcode = 0x91},
        side<Whole>(
            summed, 24, u8(&Whole::byte, {.name = "byte", .byte = 6, .range = {1, 200}}),
            i8(&Whole::signed_byte, {.name = "signed_byte", .byte = 7}),
            u16_le(&Whole::low_first, {.name = "low_first", .byte = 8}),
            i16_le(&Whole::signed_low_first, {.name = "signed_low_first", .byte = 10, .range = {-100, 100}}),
            u16_be(&Whole::high_first, {.name = "high_first", .byte = 12}),
            i32_le(&Whole::degrees, {.name = "degrees", .byte = 14, .unit = "deg", .scale = 0.01, .offset = -5.0}),
            u48_le(&Whole::six, {.name = "six", .byte = 18})),
        side<Packed>(summed, 22, u32_le(&Packed::low_first, {.name = "low_first", .byte = 6}),
                     i56_le(&Packed::seven, {.name = "seven", .byte = 10}),
                     bits(&Packed::mode, 7, 5, {.name = "mode", .byte = 17, .range = {0, 2}, .labels = modes}),
                     bits(&Packed::is_hot, 4, 4, {.name = "is_hot", .byte = 17}), reserved("free", 17, 3, 0),
                     septets(&Packed::septets, 3, 2, {.name = "septets", .byte = 18}),
                     signed_septets(&Packed::signed_septets, {.name = "signed_septets", .byte = 20})));
}

/// A constant behind the first eight bytes, and a value that is sent twice.
struct Far {
    std::uint8_t value{};
};
consteval auto row_of(const Far*)
{
    return message<Far, Nothing>({.name = "far", .opcode = 0x12, .access = Access::command},
                                 side<Far>(summed, 9, u8(&Far::value, {.name = "value", .byte = 6}),
                                           repeat("value_again", 7, 6), constant("tail", 8, 0x33)),
                                 no_side);
}

// ---- serial lines: `FF mode:3+id:5 opcode values … sum`, answered by bare bytes ----

inline constexpr Field crossed_fields[] = {
    constant("header", 0, 0xFF),
    constant_bits("mode", 1, 7, 5, 5),
    {.name = "id", .byte = 1, .msb = 4, .lsb = 0, .kind = Kind::address, .range = {0, 31}},
    {.name = "opcode", .byte = 2, .kind = Kind::opcode},
    {.name = "sum", .from_end = true, .kind = Kind::checksum}};
inline constexpr Layout crossed{
    .name = "crossed", .checksum = Checksum::xor7, .fields = crossed_fields, .ids = {0, 31}};
inline constexpr Layout bare{.name = "bare"};

struct Steps {
    std::uint8_t count{};
    std::array<Pair, 9> steps{};
};
struct Count {
    std::uint8_t count{};
};
consteval auto row_of(const Steps*)
{
    return message<Steps, Count>(
        {.name = "steps", .opcode = 0x21, .access = Access::flash, .broadcast = true},
        side<Steps>(crossed, 6, u8(&Steps::count, {.name = "count", .byte = 3, .range = {0, 9}}),
                    Field{.name = "free", .byte = 4, .kind = Kind::reserved, .fixed = 0x0F},
                    pairs(&Steps::steps, &Steps::count, {.name = "steps", .byte = 5, .range = {0, 254}})),
        side<Count>(bare, 2, u8(&Count::count, {.name = "count", .byte = 0, .range = {0, 9}}), repeat("again", 1, 0)));
}

/// A position in the low half of a byte and the next one, whose bit 7 a receiver masks; state in the other half.
struct Look {
};
struct Seen {
    std::uint8_t state{};
    std::uint16_t position{};
};
consteval auto row_of(const Look*)
{
    return message<Look, Seen>(
        {.name = "look", .opcode = 0x22}, side<Look>(crossed, 4),
        side<Seen>(bare, 2, bits(&Seen::state, 7, 4, {.name = "state", .byte = 0, .range = {0, 9}}),
                   septets(&Seen::position, 4, 2, {.name = "position", .byte = 0, .shares_top = true, .lenient = 1})));
}

// ---- CAN: `140 + id`, and `280` for everybody ----

inline constexpr std::uint32_t high_comes_first = 1U << 0;
inline constexpr std::uint32_t other_answer = 1U << 1;

inline constexpr Field can_fields[] = {{.name = "opcode", .byte = 0, .kind = Kind::opcode}};
inline constexpr Layout can{.name = "can", .fields = can_fields, .can_base = 0x140, .ids = {1, 32}};
inline constexpr Layout everybody{
    .name = "everybody", .fields = can_fields, .can_base = 0x280, .can_fixed = true, .ids = {0, 0}};

/// `value` is a number, or with `which` 7 two numbers of a byte.
struct Parameter {
    std::uint8_t which{};
    std::int32_t value{};
};
inline constexpr Field halves[] = {{.name = "left", .byte = 4, .range = {0, 50}}, {.name = "right", .byte = 5}};
inline constexpr Variant variants[] = {{7, "halves", halves}};
consteval auto parameter_side()
{
    auto s = side<Parameter>(can, 8, u8(&Parameter::which, {.name = "which", .byte = 1}), reserved("free", 2),
                             reserved("free_too", 3), i32_le(&Parameter::value, {.name = "value", .byte = 4}));
    s.selector = "which";
    s.replaced = "value";
    s.variants = variants;
    return s;
}
consteval auto row_of(const Parameter*)
{
    return message<Parameter, Parameter>({.name = "parameter", .opcode = 0xC0}, parameter_side(), parameter_side());
}

/// Two bytes of which either may come first; answered by one of two opcodes.
struct Edges {
    std::uint8_t low{}, high{};
};
consteval auto row_of(const Edges*)
{
    constexpr When high_first{high_comes_first, high_comes_first};
    constexpr When low_first{high_comes_first, 0};
    return message<Edges, Nothing>(
        {.name = "edges", .opcode = 0x76, .reply_opcode_also = 0, .also_when = other_answer, .access = Access::command},
        side<Edges>(can, 3, u8(&Edges::low, {.name = "low", .byte = 1, .range = {0, 99}, .when = low_first}),
                    u8(&Edges::high, {.name = "high", .byte = 2, .range = {0, 99}, .when = low_first}),
                    u8(&Edges::high, {.name = "high", .byte = 1, .range = {0, 99}, .when = high_first}),
                    u8(&Edges::low, {.name = "low", .byte = 2, .range = {0, 99}, .when = high_first})),
        side<Nothing>(can, 1));
}

struct Everybody {
    std::uint8_t value{};
};
consteval auto row_of(const Everybody*)
{
    return message<Everybody, Count>({.name = "everybody", .opcode = 0x77, .broadcast = true},
                                     side<Everybody>(everybody, 2, u8(&Everybody::value, {.name = "value", .byte = 1})),
                                     side<Count>(can, 2, u8(&Count::count, {.name = "count", .byte = 1})));
}

inline constexpr auto all_messages = catalogue(MessageList<Whole, Far, Steps, Look, Parameter, Edges, Everybody>{});

} // namespace sinew::wire::fake
