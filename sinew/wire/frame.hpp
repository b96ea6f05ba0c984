#pragma once
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <span>

namespace sinew::wire {

/// One message as it travels: the bytes on a serial line, or the data of one CAN frame with its identifier.
/// A regular value without heap; the largest frame of the three families is SAM's motion program with 22 bytes.
struct Frame {
    static constexpr std::size_t capacity = 24;

    std::uint32_t can_id = 0; ///< 11-bit identifier; 0 on serial lines
    std::uint8_t size = 0;    ///< bytes in use; the DLC on CAN
    std::array<std::uint8_t, capacity> data{};

    /// A frame of these bytes, at most `capacity` of them.
    static Frame of(std::span<const std::uint8_t> bytes)
    {
        Frame frame;
        frame.assign(bytes);
        return frame;
    }
    /// The same in place.
    void assign(std::span<const std::uint8_t> bytes);

    std::span<const std::uint8_t> bytes() const { return std::span(data).first(size); }
    /// The first eight bytes in one word, for comparing them at once; bytes that are not in use count as they stand.
    std::uint64_t first_eight() const
    {
        std::uint64_t word = 0;
        std::memcpy(&word, data.data(), sizeof word);
        return word;
    }

    friend constexpr bool operator==(const Frame& a, const Frame& b)
    {
        if (a.can_id != b.can_id || a.size != b.size)
            return false;
        for (std::size_t i = 0; i < a.size; ++i)
            if (a.data[i] != b.data[i])
                return false;
        return true;
    }
};

/// In pieces of fixed size that may overlap: a copy of unknown size is a call, and frames are short.
[[gnu::always_inline]] inline void Frame::assign(std::span<const std::uint8_t> bytes)
{
    assert(bytes.size() <= capacity);
    const std::uint8_t* from = bytes.data();
    std::uint8_t* to = data.data();
    const std::size_t used = bytes.size();
    const auto copy_ends = [&](std::size_t each) {
        std::memcpy(to, from, each);
        std::memcpy(to + used - each, from + used - each, each);
    };
    can_id = 0;
    size = static_cast<std::uint8_t>(used);
    data.fill(0);
    if (used >= 8) {
        if (used > 16)
            std::memcpy(to + 8, from + 8, 8);
        copy_ends(8);
    } else if (used >= 4) {
        copy_ends(4);
    } else if (used >= 2) {
        copy_ends(2);
    } else if (used == 1) {
        *to = *from;
    }
}

} // namespace sinew::wire
