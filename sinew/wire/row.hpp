#pragma once
#include "sinew/wire/field.hpp"
#include "sinew/wire/frame.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace sinew::wire {

enum class Checksum : std::uint8_t {
    none,
    xor7,    ///< SAM: XOR of all bytes after the header, AND 0x7F
    not_sum, ///< Nuri: NOT of the sum of all bytes but header and checksum
};

/// What all frames of one kind share: the bytes that belong to the framing and not to a message.
struct Layout {
    std::string_view name;
    Checksum checksum = Checksum::none;
    std::span<const Field> fields{};
    std::uint32_t can_base = 0; ///< CAN identifier is this + id (`can_fixed`: just this); 0: no CAN
    bool can_fixed = false;
    Range ids{0, 0}; ///< ids that can be addressed; on CAN the id stands in the identifier
};

/// What a message does to the device.
enum class Access : std::uint8_t {
    read,    ///< changes nothing
    command, ///< moves, switches or sets something until power-off
    flash,   ///< writes non-volatile memory, which wears out
};

/// What is said once about a message.
struct Info {
    std::string_view name;      ///< unique in its profile, with dashes
    int opcode = -1;            ///< selects the message; -1: none
    int reply_opcode = -1;      ///< selects the reply; -1: as the request
    int reply_opcode_also = -1; ///< a second one that hosts accept and a device sends while `also_when` is set
    std::uint32_t also_when = 0;
    Access access = Access::read;
    bool moves = false;               ///< can make the shaft turn, or let it go
    bool relative = false;            ///< counts from where the shaft is: sent twice it goes twice as far
    bool answered_as_command = false; ///< a device may be set to leave it unanswered (SAM response level 0)
    bool broadcast = false;           ///< an address for all devices exists
    std::string_view restriction{};   ///< models that have it; empty: all
    std::string_view manual{};        ///< section
    std::string_view errata{};        ///< numbers of the resolutions taken
    std::string_view says{};          ///< one sentence
};

/// Fields that take the place of another one while a selector has a value (RMD parameters).
struct Variant {
    std::int64_t selector{};
    std::string_view name;
    std::span<const Field> fields;
};

/// The constants and the opcode of a frame, to be compared eight bytes at once.
struct Selection {
    std::uint64_t mask = 0;  ///< the bits of the first eight bytes that say which message it is
    std::uint64_t value = 0; ///< what they are
    bool is_all = false;     ///< size and these bits tell; nothing else has to be looked at
};

/// The request or the reply of a message without its C++ type: all fields in the order of the manual, framing first.
struct Side {
    const Layout* layout = nullptr;
    std::uint8_t size = 0; ///< bytes; the least, if it ends in a sequence
    std::span<const Field> fields{};
    std::string_view selector{}; ///< name of the field that selects a variant
    std::string_view replaced{}; ///< name of the field that the variant replaces
    std::span<const Variant> variants{};
    int opcode = -1;
    int opcode_also = -1;
    std::uint32_t also_when = 0;
    Selection selection{};
    const Field* device = nullptr; ///< the field that says which device it is for or from; nullptr: none

    constexpr bool exists() const { return layout != nullptr; }
};

enum class Direction : std::uint8_t { request, reply };

/// A message without its C++ type, for everything that works by name: CLI, documentation, sniffers, fuzzers.
struct MessageInfo {
    Info info;
    Side request;
    Side reply;

    constexpr const Side& side(Direction direction) const { return direction == Direction::request ? request : reply; }
    constexpr std::string_view name() const { return info.name; }
};

/// Where the checksum of a frame of `size` bytes stands, or -1.
constexpr int checksum_byte(const Layout& layout, std::size_t size)
{
    for (const auto& field : layout.fields)
        if (field.kind == Kind::checksum)
            return field.from_end ? static_cast<int>(size) - 1 : field.byte;
    return -1;
}

/// The sum of at most 64 bytes, several at once.
[[gnu::always_inline]] constexpr unsigned sum_of(const std::uint8_t* data, std::size_t size)
{
    constexpr std::size_t few = 8;
    if (std::is_constant_evaluated() || size < 4 || (__builtin_constant_p(size) && size <= few)) {
        unsigned sum = 0;
        for (std::size_t i = 0; i < size; ++i)
            sum += data[i];
        return sum;
    }
    std::uint64_t pairs = 0; // four sums side by side
    const auto add = [&](std::uint64_t word) {
        constexpr std::uint64_t every_other = 0x00FF00FF00FF00FF;
        pairs += (word & every_other) + (word >> 8 & every_other);
    };
    const auto load = [&]<class Word>(Word word, std::size_t at) {
        std::memcpy(&word, data + at, sizeof word);
        return word;
    };
    std::size_t at = 0;
    for (; at + 8 <= size; at += 8)
        add(load(std::uint64_t{}, at));
    // What is left is the upper part of the last word, or of the last half.
    if (const std::size_t left = size - at; size >= 8 && left > 0) {
        add(load(std::uint64_t{}, size - 8) >> 8 * (8 - left));
    } else if (size < 8) {
        add(load(std::uint32_t{}, 0));
        add(std::uint64_t{load(std::uint32_t{}, size - 4)} >> 8 * (8 - size));
    }
    return static_cast<unsigned>((pairs * 0x0001000100010001) >> 48);
}

[[gnu::always_inline]] constexpr std::uint8_t checksum(Checksum kind, const std::uint8_t* data, std::size_t size)
{
    if (kind == Checksum::xor7) {
        unsigned sum = 0;
        for (std::size_t i = 1; i + 1 < size; ++i)
            sum ^= data[i];
        return sum & 0x7F;
    }
    return static_cast<std::uint8_t>(~(sum_of(data + 2, size - 2) - data[4]));
}

// ---- checks at compile time: a wrong row calls one of these, and the compiler prints its name ----

void two_fields_claim_the_same_bit();
void a_field_lies_outside_the_frame();
void a_byte_is_not_explained();
void a_range_does_not_fit_the_coding();
void two_fields_have_one_name();
void two_messages_have_one_name();
void two_messages_have_one_opcode();

consteval void check_field(const Field& f, std::size_t size)
{
    if (std::size_t{f.byte} + f.bytes > size || f.msb > 7 || f.lsb > f.msb || size > Frame::capacity)
        a_field_lies_outside_the_frame();
    const Range most = capacity(f);
    for (const Range& r : {f.range, f.recommended})
        if (r.given() && (r.low > r.high || !most.contains(r.low) || !most.contains(r.high)))
            a_range_does_not_fit_the_coding();
}

/// Every bit of the frame belongs to exactly one of the fields that apply under `options`.
consteval void check_coverage(std::span<const Field> fields, std::size_t size, Options options)
{
    std::array<std::uint8_t, Frame::capacity> seen{};
    for (const auto& f : fields) {
        if (!f.when.holds(options) || f.kind == Kind::sequence)
            continue;
        for (std::size_t byte = 0; byte < size; ++byte) {
            const std::uint8_t claim = f.from_end ? (byte + 1 == size ? 0xFF : 0) : claimed(f, byte);
            if ((seen[byte] & claim) != 0)
                two_fields_claim_the_same_bit();
            seen[byte] |= claim;
        }
    }
    for (std::size_t byte = 0; byte < size; ++byte)
        if (seen[byte] != 0xFF)
            a_byte_is_not_explained();
}

consteval Selection selection_of(const Side& side)
{
    std::array<std::uint8_t, 8> mask{};
    std::array<std::uint8_t, Frame::capacity> value{};
    bool is_all = side.opcode_also < 0;
    for (const Field& f : side.fields) {
        is_all = is_all && f.kind != Kind::sequence; // then the size differs
        if (f.kind != Kind::opcode && f.kind != Kind::constant && f.kind != Kind::size)
            continue;
        if (std::size_t{f.byte} + f.bytes > mask.size()) {
            is_all = false;
            continue;
        }
        for (std::size_t byte = f.byte; byte < std::size_t{f.byte} + f.bytes; ++byte)
            mask[byte] |= claimed(f, byte);
        put(f, f.fixed, value.data());
    }
    std::array<std::uint8_t, 8> first{};
    for (std::size_t byte = 0; byte < first.size(); ++byte)
        first[byte] = value[byte] & mask[byte];
    return {std::bit_cast<std::uint64_t>(mask), std::bit_cast<std::uint64_t>(first), is_all};
}

consteval void check_side(const Side& side)
{
    if (!side.exists())
        return;
    std::uint32_t switches = 0;
    for (std::size_t i = 0; i < side.fields.size(); ++i) {
        const Field& f = side.fields[i];
        if (!f.from_end && f.kind != Kind::sequence)
            check_field(f, side.size);
        switches |= f.when.mask;
        for (std::size_t j = 0; j < i; ++j)
            if (side.fields[j].name == f.name && side.fields[j].when.mask == f.when.mask &&
                side.fields[j].when.equals == f.when.equals)
                two_fields_have_one_name();
    }
    check_coverage(side.fields, side.size, {.bits = 0});
    if (switches != 0)
        check_coverage(side.fields, side.size, {.bits = switches});
}

} // namespace sinew::wire
