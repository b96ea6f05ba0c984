#include "sinew/link/tty.hpp"

#include <asm/termbits.h>
#include <cerrno>
#include <sys/ioctl.h>

namespace sinew::link::tty {
namespace {

void put_rate(termios2& settings, std::uint32_t bit_rate)
{
    // No rate in CIBAUD means: the input has the rate of the output.
    settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
    settings.c_cflag |= BOTHER;
    settings.c_ispeed = bit_rate;
    settings.c_ospeed = bit_rate;
}

std::expected<std::uint32_t, int> apply(int fd, const termios2& settings)
{
    if (::ioctl(fd, TCSETS2, &settings) != 0)
        return std::unexpected(errno);
    return bit_rate(fd);
}

} // namespace

std::expected<std::uint32_t, int> make_raw(int fd, std::uint32_t bit_rate)
{
    termios2 settings{};
    if (::ioctl(fd, TCGETS2, &settings) != 0)
        return std::unexpected(errno);
    settings.c_iflag = 0;
    settings.c_oflag = 0;
    settings.c_lflag = 0;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | CRTSCTS | HUPCL);
    settings.c_cflag |= CS8 | CREAD | CLOCAL;
    // With VMIN 0 an empty line would read as 0, which is what a hang-up looks like.
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    if (bit_rate != 0)
        put_rate(settings, bit_rate);
    return apply(fd, settings);
}

std::expected<std::uint32_t, int> set_bit_rate(int fd, std::uint32_t bit_rate)
{
    termios2 settings{};
    if (::ioctl(fd, TCGETS2, &settings) != 0)
        return std::unexpected(errno);
    put_rate(settings, bit_rate);
    return apply(fd, settings);
}

std::expected<std::uint32_t, int> bit_rate(int fd)
{
    termios2 settings{};
    if (::ioctl(fd, TCGETS2, &settings) != 0)
        return std::unexpected(errno);
    return settings.c_ospeed;
}

} // namespace sinew::link::tty
