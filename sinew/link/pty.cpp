#include "sinew/link/pty.hpp"

#include "sinew/link/adapter.hpp"
#include "sinew/link/tty.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

namespace sinew::link {
namespace {

std::unexpected<Error> refuse(std::string_view what)
{
    return fail(Errc::link_failed, fmt::format("cannot make a pseudo terminal ({}): {}", what, std::strerror(errno)));
}

bool add(const Fd& epoll, const Fd& fd)
{
    epoll_event event{.events = EPOLLIN, .data = {.fd = fd.get()}};
    return ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd.get(), &event) == 0;
}

/// Whether anything was there. What exactly does not matter: each of these descriptors has one thing to tell.
bool drain(const Fd& fd)
{
    bool any = false;
    std::array<char, 4096> told;
    while (::read(fd.get(), told.data(), told.size()) > 0)
        any = true;
    return any;
}

} // namespace

std::expected<std::unique_ptr<PtyMaster>, Error> PtyMaster::open(std::uint32_t bit_rate, const Clock& clock)
{
    Fd master{::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    std::array<char, 64> device{};
    if (!master || ::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
        ::ptsname_r(master.get(), device.data(), device.size()) != 0)
        return refuse("/dev/ptmx");
    Watch watch{.client = Fd{::open(device.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)},
                .closes = Fd{::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)},
                .again = Fd{::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)},
                .wake = Fd{::epoll_create1(EPOLL_CLOEXEC)}};
    if (!watch.client || !tty::make_raw(watch.client.get(), bit_rate))
        return refuse(device.data());
    if (!watch.closes || ::inotify_add_watch(watch.closes.get(), device.data(), IN_CLOSE) < 0 || !watch.again ||
        !watch.wake || !add(watch.wake, master) || !add(watch.wake, watch.closes) || !add(watch.wake, watch.again))
        return refuse("watching for closes");
    return std::unique_ptr<PtyMaster>(new PtyMaster(std::move(master), std::move(watch), device.data(), clock));
}

PtyMaster::PtyMaster(Fd master, Watch watch, std::string device, const Clock& clock)
    : master_(std::move(master), device, clock), watch_(std::move(watch)), device_(std::move(device))
{
}

std::uint32_t PtyMaster::client_bit_rate() const
{
    return tty::bit_rate(watch_.client.get()).value_or(0);
}

std::expected<Arrival, Error> PtyMaster::read(std::span<std::uint8_t> into)
{
    clear_claim_left_behind();
    return master_.read(into);
}

void PtyMaster::clear_claim_left_behind()
{
    const bool closed = drain(watch_.closes);
    const bool second_look = drain(watch_.again);
    if (!closed && !second_look)
        return;
    if (!lock_holder(device_)) {
        ::ioctl(watch_.client.get(), TIOCNXCL);
    } else if (closed) {
        // The kernel tells of a close a moment before it lifts the lock of the same program.
        const itimerspec soon{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_nsec = 10'000'000}};
        ::timerfd_settime(watch_.again.get(), 0, &soon, nullptr);
    }
}

std::expected<std::uint32_t, Error> PtyMaster::set_bit_rate(std::uint32_t)
{
    return fail(Errc::unsupported, fmt::format("the program that opens {} sets its bit rate", device_));
}

} // namespace sinew::link
