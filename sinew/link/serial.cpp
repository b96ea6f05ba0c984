#include "sinew/link/serial.hpp"

#include "sinew/link/adapter.hpp"
#include "sinew/link/descriptor.hpp"
#include "sinew/link/echo.hpp"
#include "sinew/link/tty.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>

namespace sinew::link {
namespace {

std::unexpected<Error> refuse_access(const std::string& device)
{
    const auto group = look_at_adapter(device).group;
    if (group.empty())
        return fail(Errc::link_denied, fmt::format("no permission to open {}; only its owner and root may", device));
    return fail(
        Errc::link_denied,
        fmt::format("no permission to open {}; join its group with `sudo usermod -aG {} $USER` and log in again",
                    device, group));
}

std::unexpected<Error> busy(const std::string& device)
{
    const auto who = who_holds(device);
    return fail(
        Errc::link_busy,
        who.empty()
            ? fmt::format("{0} is in use by another program; close it first (`sudo fuser -v {0}` names it)", device)
            : fmt::format("{} is in use by {}; close it first", device, who));
}

std::unexpected<Error> refuse(const std::string& device, int problem)
{
    switch (problem) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case EIO: // what a port of the board without hardware behind it says
        return fail(
            Errc::link_not_found,
            fmt::format("there is no device {}; is it plugged in and powered? (`ls /dev/tty*` lists what is there)",
                        device));
    case EACCES:
    case EPERM:
        return refuse_access(device);
    case EBUSY:
        return busy(device);
    case ENOTTY:
        return fail(Errc::link_failed, fmt::format("{} is not a serial port", device));
    default:
        return fail(Errc::link_failed, fmt::format("cannot use {}: {}", device, std::strerror(problem)));
    }
}

std::unexpected<Error> refuse_rate(const std::string& device, std::uint32_t asked, std::uint32_t set)
{
    return fail(Errc::unsupported,
                fmt::format("{} cannot do {} baud; the nearest that it makes is {}", device, asked, set));
}

class SerialLink final : public ByteLink
{
public:
    SerialLink(Fd fd, std::string device, std::uint32_t bit_rate, const Clock& clock)
        : descriptor_(std::move(fd), device, clock), device_(std::move(device)), bit_rate_(bit_rate)
    {
    }

    ~SerialLink() override
    {
        // The mark belongs to the device, not to the descriptor: where something else holds the device open, such as
        // the simulator its pseudo terminal, it would lock out everybody after us.
        if (descriptor_.is_open())
            ::ioctl(descriptor_.fd(), TIOCNXCL);
    }

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        return descriptor_.write(bytes);
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override { return descriptor_.read(into); }
    int handle() const override { return descriptor_.fd(); }
    LinkState state() const override { return {.open = descriptor_.is_open(), .bit_rate = bit_rate_}; }

    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override
    {
        if (!descriptor_.is_open())
            return std::unexpected(descriptor_.write({}).error());
        const auto set = bit_rate == 0 ? std::unexpected(EINVAL) : tty::set_bit_rate(descriptor_.fd(), bit_rate);
        if (set && tty::is_near(bit_rate, *set))
            return bit_rate_ = *set;
        if (!set && set.error() != EINVAL)
            return descriptor_.hang_up(std::strerror(set.error()));
        (void)tty::set_bit_rate(descriptor_.fd(), bit_rate_); // back to the old one; the refusal is what counts
        return refuse_rate(device_, bit_rate, set.value_or(bit_rate_));
    }

private:
    Descriptor descriptor_;
    std::string device_;
    std::uint32_t bit_rate_;
};

/// A driver without the setting is left as it is, see the header; 0 or errno.
int switch_direction_in_driver(int fd, bool hears_itself)
{
    serial_rs485 setting{};
    if (::ioctl(fd, TIOCGRS485, &setting) != 0)
        return errno == ENOTTY ? 0 : errno;
    setting.flags |= SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND;
    setting.flags &= ~static_cast<__u32>(SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX);
    if (hears_itself)
        setting.flags |= SER_RS485_RX_DURING_TX;
    return ::ioctl(fd, TIOCSRS485, &setting) == 0 || errno == ENOTTY ? 0 : errno;
}

/// FTDI adapters hold received bytes for 16 ms otherwise. Not every driver has it, and none of them must.
void ask_for_low_latency(int fd)
{
    serial_struct setting{};
    if (::ioctl(fd, TIOCGSERIAL, &setting) != 0)
        return;
    setting.flags |= ASYNC_LOW_LATENCY;
    ::ioctl(fd, TIOCSSERIAL, &setting);
}

constexpr int flush_input = 0; // TCIFLUSH, which <termios.h> and <asm/termbits.h> both define

} // namespace

std::expected<std::unique_ptr<ByteLink>, Error> open_serial(const SerialPort& port, Clock& clock)
{
    Fd fd{::open(port.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!fd)
        return refuse(port.device, errno);
    if (const auto before = tty::bit_rate(fd.get()); !before)
        return refuse(port.device, before.error());
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0)
        return errno == EWOULDBLOCK ? busy(port.device) : refuse(port.device, errno);

    const auto set = tty::make_raw(fd.get(), port.bit_rate);
    if (!set && set.error() == EINVAL)
        return fail(Errc::unsupported, fmt::format("{} cannot do {} baud", port.device, port.bit_rate));
    if (!set)
        return refuse(port.device, set.error());
    if (port.bit_rate != 0 && !tty::is_near(port.bit_rate, *set))
        return refuse_rate(port.device, port.bit_rate, *set);
    if (port.rs485)
        if (const int problem = switch_direction_in_driver(fd.get(), port.echo == Echo::on); problem != 0)
            return fail(Errc::link_failed,
                        fmt::format("the driver of {} refuses to switch the direction for RS-485: {}", port.device,
                                    std::strerror(problem)));
    ask_for_low_latency(fd.get());
    ::ioctl(fd.get(), TCFLSH, flush_input);
    ::ioctl(fd.get(), TIOCEXCL);

    std::unique_ptr<ByteLink> link = std::make_unique<SerialLink>(std::move(fd), port.device, *set, clock);
    return with_echo(std::move(link), port.echo, clock);
}

std::expected<std::unique_ptr<ByteLink>, Error> open_serial(const Uri& uri, Clock& clock)
{
    const auto baud = uri.number("baud");
    if (!baud)
        return std::unexpected(baud.error());
    if (!*baud && uri.scheme != "pty")
        return fail(Errc::bad_uri,
                    fmt::format("'{0}' does not say its bit rate: add ?baud=RATE, such as {1}:{2}?baud=115200",
                                to_string(uri), uri.scheme, uri.target));
    const auto echo = echo_option(uri);
    if (!echo)
        return std::unexpected(echo.error());
    return open_serial(
        {.device = uri.target, .bit_rate = baud->value_or(0), .rs485 = uri.scheme == "rs485", .echo = *echo}, clock);
}

} // namespace sinew::link
