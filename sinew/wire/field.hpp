#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

/// Rows: one description of each wire fact, from which everything else is made.
namespace sinew::wire {

/// An inclusive range of raw values.
struct Range {
    std::int64_t low = std::numeric_limits<std::int64_t>::min();
    std::int64_t high = std::numeric_limits<std::int64_t>::max();

    constexpr bool contains(std::int64_t value) const { return low <= value && value <= high; }
    constexpr bool given() const { return low != std::numeric_limits<std::int64_t>::min(); }
    friend constexpr bool operator==(const Range&, const Range&) = default;
};

/// A name for one raw value.
struct Label {
    std::int64_t value{};
    std::string_view name{};
};

/// Switches of a firmware line that change where something stands. One bit each; the families name theirs.
struct Options {
    std::uint32_t bits = 0;
    std::uint32_t can_reply_base = 0; ///< identifier of replies is this + id; 0: as the layout says

    constexpr bool has(std::uint32_t bit) const { return (bits & bit) != 0; }
};

/// A field that applies only while `(options.bits & mask) == equals`.
struct When {
    std::uint32_t mask = 0;
    std::uint32_t equals = 0;

    constexpr bool holds(Options options) const { return (options.bits & mask) == equals; }
};

/// How the bits of a value lie in the frame.
enum class Coding : std::uint8_t {
    bits, ///< unsigned, bits msb … lsb of one byte
    u_le,
    i_le,           ///< whole bytes, least significant first
    u_be,           ///< whole bytes, most significant first
    septets,        ///< SAM: 7 bits in each low byte, `top_bits` in the first; bit 7 of a low byte stays clear
    signed_septets, ///< SAM: sign in bit 7 of the first byte, then 7 + 7 bits of magnitude
};

/// What a field is there for.
enum class Kind : std::uint8_t {
    value,    ///< carries meaning
    constant, ///< always `fixed`; anything else is refused
    reserved, ///< `fixed` is sent, anything is accepted
    repeat,   ///< the byte at `source` once more; refused when it differs
    sequence, ///< pairs of bytes, as many as the field before it says
    opcode,   ///< a constant that the message fills in
    size,     ///< a constant: bytes after this one
    address,  ///< id of the device
    checksum, ///< computed; `byte` counts from the end of the frame when `from_end`
};

/// A scale that differs from model to model; the tables of models give it.
inline constexpr double by_model = 0.0;

/// One run of bits in a frame. Bytes count from the first byte of the frame, or of the CAN data.
struct Field {
    std::string_view name{};
    std::uint8_t byte{};    ///< the first byte
    std::uint8_t bytes = 1; ///< how many
    std::uint8_t msb = 7;   ///< inside the byte, coding `bits` only
    std::uint8_t lsb = 0;
    std::uint8_t top_bits = 8; ///< septets: bits used in the first byte
    bool shares_top = false;   ///< septets: the other bits of the first byte belong to another field
    std::uint8_t lenient = 0;  ///< septets: a receiver masks bit 7 of this byte (counted from `byte`; 0: of none)
    bool from_end = false;
    Coding coding = Coding::bits;
    Kind kind = Kind::value;
    std::uint8_t source{}; ///< of a repeat
    std::int64_t fixed{};
    Range range{};           ///< what may travel; not given: whatever fits
    Range recommended{};     ///< what a host should send where that is narrower
    std::string_view unit{}; ///< the manual's unit of `raw * scale + offset`; empty: a plain number
    double scale = 1.0;      ///< 0: the model says
    double offset = 0.0;
    std::span<const Label> labels{};
    std::string_view says{}; ///< only what name, unit and range do not tell
    When when{};
};

/// The largest range that the coding of a field can carry.
constexpr Range capacity(const Field& f)
{
    const auto unsigned_bits = [](int bits) { return Range{0, (std::int64_t{1} << bits) - 1}; };
    switch (f.coding) {
    case Coding::bits:
        return unsigned_bits(f.msb - f.lsb + 1);
    case Coding::u_le:
    case Coding::u_be:
        return unsigned_bits(8 * f.bytes);
    case Coding::i_le: {
        const std::int64_t half = std::int64_t{1} << (8 * f.bytes - 1);
        return {-half, half - 1};
    }
    case Coding::septets:
        return unsigned_bits(f.top_bits + 7 * (f.bytes - 1));
    case Coding::signed_septets:
        return {-0x3FFF, 0x3FFF};
    }
    return {};
}

/// What may travel: the printed range, or all that the coding carries.
constexpr Range allowed(const Field& f)
{
    return f.range.given() ? f.range : capacity(f);
}

/// The bits of byte `byte` that the field explains.
constexpr std::uint8_t claimed(const Field& f, std::size_t byte)
{
    if (byte < f.byte || byte >= std::size_t{f.byte} + f.bytes)
        return 0;
    if (f.coding == Coding::bits)
        return static_cast<std::uint8_t>(((1U << (f.msb - f.lsb + 1)) - 1U) << f.lsb);
    if (f.coding == Coding::septets && f.shares_top && byte == f.byte)
        return static_cast<std::uint8_t>((1U << f.top_bits) - 1U);
    return 0xFF;
}

/// Writes a value that is in range. The bits must be clear before.
[[gnu::always_inline]] constexpr void put(const Field& f, std::int64_t value, std::uint8_t* data)
{
    auto rest = static_cast<std::uint64_t>(value);
    const auto byte_at = [&](std::size_t i) -> std::uint8_t& { return data[f.byte + i]; };
    switch (f.coding) {
    case Coding::bits:
        byte_at(0) = static_cast<std::uint8_t>(byte_at(0) | (rest << f.lsb));
        break;
    case Coding::u_le:
    case Coding::i_le:
        for (std::size_t i = 0; i < f.bytes; ++i, rest >>= 8)
            byte_at(i) = static_cast<std::uint8_t>(rest);
        break;
    case Coding::u_be:
        for (std::size_t i = f.bytes; i-- > 0; rest >>= 8)
            byte_at(i) = static_cast<std::uint8_t>(rest);
        break;
    case Coding::septets:
        for (std::size_t i = f.bytes; --i > 0; rest >>= 7)
            byte_at(i) = rest & 0x7F;
        byte_at(0) = static_cast<std::uint8_t>(byte_at(0) | rest);
        break;
    case Coding::signed_septets: {
        const auto magnitude = static_cast<std::uint64_t>(value < 0 ? -value : value);
        byte_at(0) = static_cast<std::uint8_t>((value < 0 ? 0x80U : 0U) | (magnitude >> 7));
        byte_at(1) = magnitude & 0x7F;
        break;
    }
    }
}

/// Reads a value. False when a bit is set that the coding never sets.
[[gnu::always_inline]] constexpr bool get(const Field& f, const std::uint8_t* data, std::int64_t& value)
{
    std::uint64_t raw = 0;
    const auto byte_at = [&](std::size_t i) -> std::uint64_t { return data[f.byte + i]; };
    switch (f.coding) {
    case Coding::bits:
        raw = (byte_at(0) >> f.lsb) & ((1U << (f.msb - f.lsb + 1)) - 1U);
        break;
    case Coding::u_le:
    case Coding::i_le:
        for (std::size_t i = f.bytes; i-- > 0;)
            raw = raw << 8 | byte_at(i);
        if (f.coding == Coding::i_le) {
            const int unused = 64 - 8 * f.bytes;
            value = static_cast<std::int64_t>(raw << unused) >> unused;
            return true;
        }
        break;
    case Coding::u_be:
        for (std::size_t i = 0; i < f.bytes; ++i)
            raw = raw << 8 | byte_at(i);
        break;
    case Coding::septets: {
        const std::uint64_t top = byte_at(0) & ((1U << f.top_bits) - 1U);
        if (!f.shares_top && top != byte_at(0))
            return false;
        raw = top;
        for (std::size_t i = 1; i < f.bytes; ++i) {
            if (byte_at(i) > 0x7F && f.lenient != i)
                return false;
            raw = raw << 7 | (byte_at(i) & 0x7F);
        }
        break;
    }
    case Coding::signed_septets: {
        if (byte_at(1) > 0x7F)
            return false;
        const auto magnitude = static_cast<std::int64_t>((byte_at(0) & 0x7F) << 7 | byte_at(1));
        value = (byte_at(0) & 0x80) != 0 ? -magnitude : magnitude;
        return true;
    }
    }
    value = static_cast<std::int64_t>(raw);
    return true;
}

} // namespace sinew::wire
