#pragma once
#include <cstdint>
#include <span>

namespace sinew::record {

/// CRC-32 as zlib computes it (IEEE 802.3, reflected), continued from that of the bytes `before`.
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

} // namespace sinew::record
