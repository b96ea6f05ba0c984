#include "sinew/record/crc32.hpp"

#include "sinew/record/little_endian.hpp"

#include <array>

namespace sinew::record {
namespace {

// Eight bytes a step ("slicing by 8"): a recording is read and written faster than one byte at a time would allow.
constexpr std::size_t slices = 8;

constexpr auto tables = [] {
    constexpr std::uint32_t polynomial = 0xEDB8'8320;
    std::array<std::array<std::uint32_t, 256>, slices> out{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t value = byte;
        for (int bit = 0; bit < 8; ++bit)
            value = value >> 1U ^ ((value & 1U) != 0 ? polynomial : 0U);
        out[0][byte] = value;
    }
    for (std::size_t slice = 1; slice < slices; ++slice)
        for (std::size_t byte = 0; byte < 256; ++byte)
            out[slice][byte] = out[slice - 1][byte] >> 8U ^ out[0][out[slice - 1][byte] & 0xFFU];
    return out;
}();

} // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before)
{
    std::uint32_t crc = ~before;
    for (; bytes.size() >= slices; bytes = bytes.subspan(slices)) {
        const std::uint64_t eight = get_number(bytes.first(slices)) ^ crc;
        crc = 0;
        for (std::size_t i = 0; i < slices; ++i)
            crc ^= tables[slices - 1 - i][eight >> (8 * i) & 0xFFU];
    }
    for (const std::uint8_t byte : bytes)
        crc = crc >> 8U ^ tables[0][(crc ^ byte) & 0xFFU];
    return ~crc;
}

} // namespace sinew::record
