#pragma once
#include <array>
#include <cstdint>
#include <span>

namespace sinew::wire {

/// One message as it travels: the bytes on a serial line, or the data of one CAN frame with its identifier.
/// A regular value without heap; the largest frame of the three families is SAM's motion program with 22 bytes.
struct Frame {
    static constexpr std::size_t capacity = 24;

    std::uint32_t can_id = 0; ///< 11-bit identifier; 0 on serial lines
    std::uint8_t size = 0;    ///< bytes in use; the DLC on CAN
    std::array<std::uint8_t, capacity> data{};

    std::span<const std::uint8_t> bytes() const { return std::span(data).first(size); }

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

} // namespace sinew::wire
