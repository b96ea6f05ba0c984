#pragma once
#include <cstdint>
#include <expected>

/// Terminal settings through termios2, which knows any bit rate. Kept apart because <asm/termbits.h> and <termios.h>
/// cannot stand in one file. Errors are values of errno.
namespace sinew::link::tty {

/// Raw 8N1: no echo, no translation, no flow control, modem lines left alone at the close. `bit_rate` 0 leaves the
/// rate. Returns the rate that was really set.
std::expected<std::uint32_t, int> make_raw(int fd, std::uint32_t bit_rate);

/// Changes only the rate, at once: bytes that are still on their way out go at the new one. Returns the rate that was
/// really set.
std::expected<std::uint32_t, int> set_bit_rate(int fd, std::uint32_t bit_rate);

/// On the master of a pseudo terminal: the rate of its client.
std::expected<std::uint32_t, int> bit_rate(int fd);

/// Whether devices that sample in the middle of a bit still understand each other: 2 %, half of what 8N1 takes.
constexpr bool is_near(std::uint32_t asked, std::uint32_t set)
{
    const std::uint64_t off = asked > set ? asked - set : set - asked;
    return off * 50 <= asked;
}

} // namespace sinew::link::tty
