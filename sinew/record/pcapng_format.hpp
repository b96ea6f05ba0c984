#pragma once
#include <cstddef>
#include <cstdint>

/// What pcapng files are made of: blocks, options and flags, as reader and writer need them.
namespace sinew::record::pcapng {

inline constexpr std::uint32_t section_block = 0x0A0D'0D0A, interface_block = 1, simple_packet = 3, packet_block = 6;
inline constexpr std::uint32_t byte_order_magic = 0x1A2B'3C4D;
inline constexpr std::uint16_t end_of_options = 0, comment = 1;
inline constexpr std::uint16_t user_application = 4; // of a section
inline constexpr std::uint16_t interface_name = 2, description = 3, time_resolution = 9,
                               time_offset = 14; // of an interface
inline constexpr std::uint16_t packet_flags = 2; // of a packet
inline constexpr std::uint32_t direction_bits = 3, inbound = 1, outbound = 2;
inline constexpr std::uint16_t can_socketcan = 227, user0 = 147;
inline constexpr std::uint8_t nanoseconds = 9;

inline constexpr std::uint32_t extended_flag = 0x8000'0000, remote_flag = 0x4000'0000, error_flag = 0x2000'0000;
inline constexpr std::uint32_t identifier_bits = 0x1FFF'FFFF, standard_bits = 0x7FF;
inline constexpr std::uint8_t fd_frame_flag = 0x04;
inline constexpr std::size_t can_header = 8, most_data = 8;
inline constexpr std::size_t block_frame = 12; // type, length, and the length again

constexpr std::size_t padded(std::size_t size)
{
    return (size + 3) / 4 * 4;
}

} // namespace sinew::record::pcapng
