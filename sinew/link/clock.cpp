#include "sinew/link/clock.hpp"

#include <algorithm>
#include <array>
#include <poll.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

namespace sinew::link {

TimePoint RealClock::now() const
{
    timespec t;
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return TimePoint{std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec}};
}

void RealClock::wait_since(TimePoint now, std::span<const Handle> handles, TimePoint deadline)
{
    std::array<pollfd, max_handles> polled; // ppoll does not read `revents`
    const std::size_t count = std::min(handles.size(), polled.size());
    for (std::size_t i = 0; i < count; ++i) {
        polled[i].fd = handles[i].fd; // ppoll passes over negative ones
        polled[i].events = static_cast<short>(POLLIN + POLLOUT * static_cast<int>(handles[i].wants_write));
    }
    const Duration left = std::max(deadline - now, Duration::zero());
    const bool is_long = left >= std::chrono::seconds(1);
    const auto whole = is_long ? std::chrono::floor<std::chrono::seconds>(left) : std::chrono::seconds(0);
    timespec limit{.tv_sec = whole.count(), .tv_nsec = (left - whole).count()};
    // A signal ends the wait early, which the contract allows: the caller looks at its deadline anyway. Not by the
    // function of the C library, which keeps a copy of the limit because the kernel writes what is left of it there.
    static_assert(sizeof limit.tv_sec == 8 && sizeof limit.tv_nsec == 8);
    ::syscall(SYS_ppoll, polled.data(), count, &limit, nullptr, 0);
}

} // namespace sinew::link
