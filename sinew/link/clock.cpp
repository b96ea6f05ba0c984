#include "sinew/link/clock.hpp"

#include <algorithm>
#include <array>
#include <poll.h>
#include <time.h>

namespace sinew::link {

TimePoint RealClock::now() const
{
    timespec t{};
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return TimePoint{std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec}};
}

void RealClock::wait(std::span<const Handle> handles, TimePoint deadline)
{
    std::array<pollfd, max_handles> polled;
    std::size_t count = 0;
    for (const Handle& handle : handles) {
        if (handle.fd < 0)
            continue;
        if (count == polled.size())
            break;
        const short wanted = handle.wants_write ? POLLIN | POLLOUT : POLLIN;
        polled[count++] = {.fd = handle.fd, .events = wanted, .revents = 0};
    }
    const Duration left = std::max(deadline - now(), Duration::zero());
    const auto whole = std::chrono::floor<std::chrono::seconds>(left);
    const timespec limit{.tv_sec = whole.count(), .tv_nsec = (left - whole).count()};
    // A signal ends the wait early, which the contract allows: the caller looks at its deadline anyway.
    ::ppoll(polled.data(), count, &limit, nullptr);
}

} // namespace sinew::link
