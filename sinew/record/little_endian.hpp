#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// Numbers in the order of bytes that recordings are written in.
namespace sinew::record {

/// Appends the lowest `size` bytes, 8 at most.
inline void put_number(std::string& out, std::uint64_t value, std::size_t size)
{
    std::array<char, 8> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<char>(value >> (8 * i) & 0xFF);
    out.append(bytes.data(), size);
}

/// Of at most 8 bytes.
inline std::uint64_t get_number(std::span<const std::uint8_t> bytes)
{
    std::uint64_t value = 0;
    for (std::size_t i = bytes.size(); i-- > 0;)
        value = value << 8 | bytes[i];
    return value;
}

/// The bytes of a text, and back.
inline std::span<const std::uint8_t> bytes_of(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
inline std::string_view text_of(std::span<const std::uint8_t> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace sinew::record
