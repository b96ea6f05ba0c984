#include "apps/cli/interrupt.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>

namespace sinew::cli {
namespace {

// A signal handler reaches nothing but static storage.
std::atomic<bool> caught{false};
std::atomic<bool> suspension{false};
std::atomic<int> undisturbed{0};
std::atomic<int> wake{-1}; // can be read once one was caught
std::array<std::atomic<bus::Bus*>, 64> buses{};

void stop_buses()
{
    for (auto& slot : buses)
        if (auto* bus = slot.load())
            bus->request_stop();
}

extern "C" void on_interrupt(int number)
{
    const int error = errno;
    suspension.store(number == SIGTSTP);
    interrupt();
    errno = error;
}

} // namespace

void interrupt()
{
    caught.store(true);
    (void)::eventfd_write(wake.load(), 1);
    if (undisturbed.load() == 0)
        stop_buses();
}

bool was_suspension()
{
    return suspension.load();
}

void tell_of_suspension()
{
    fmt::print(stderr, "A program that is suspended cannot stop its motor, so it is stopped and this ends.\n");
}

void catch_suspension()
{
    struct sigaction action{};
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    sigaction(SIGTSTP, &action, nullptr);
    // Then a line to a terminal of somebody else is written, and one that is read ends at once.
    action.sa_handler = SIG_IGN;
    for (const int number : {SIGTTIN, SIGTTOU})
        sigaction(number, &action, nullptr);
}

Undisturbed::Undisturbed()
{
    // One within another must not take back what came during the outer one.
    if (undisturbed.fetch_add(1) == 0)
        clear_interrupt();
}

Undisturbed::~Undisturbed()
{
    if (undisturbed.fetch_sub(1) == 1 && interrupted())
        stop_buses();
}

void catch_interrupts()
{
    if (wake.load() < 0)
        wake.store(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
    struct sigaction action{};
    action.sa_handler = on_interrupt;
    sigemptyset(&action.sa_mask);
    // A terminal that is gone, Ctrl-\ and a reader that has left must not leave a motor turning either.
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE})
        sigaction(number, &action, nullptr);
}

bool interrupted()
{
    return caught.load();
}

bool wait_for_input(int fd)
{
    // Not by the signal that ends a wait: one that came a moment before it would be missed.
    std::array<pollfd, 2> waited{pollfd{.fd = fd, .events = POLLIN, .revents = 0},
                                 pollfd{.fd = wake.load(), .events = POLLIN, .revents = 0}};
    while (!interrupted() && ::poll(waited.data(), waited.size(), -1) < 0 && errno == EINTR)
        ;
    return !interrupted();
}

void clear_interrupt()
{
    caught.store(false);
    eventfd_t seen = 0;
    (void)::eventfd_read(wake.load(), &seen);
    for (auto& slot : buses)
        if (auto* bus = slot.load())
            bus->clear_stop();
}

StopOnInterrupt::StopOnInterrupt(bus::Bus& bus) : bus_(&bus)
{
    for (auto& slot : buses) {
        bus::Bus* free = nullptr;
        if (slot.compare_exchange_strong(free, bus_))
            break;
    }
    if (interrupted())
        bus_->request_stop();
}

StopOnInterrupt::~StopOnInterrupt()
{
    for (auto& slot : buses) {
        bus::Bus* mine = bus_;
        slot.compare_exchange_strong(mine, nullptr);
    }
}

} // namespace sinew::cli
