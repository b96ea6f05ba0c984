#include "sinew/link/clock.hpp"

#include <algorithm>
#include <alloca.h>
#include <array>
#include <poll.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

namespace sinew::link {

namespace {

// What is rare stands apart: the usual wait is part of every exchange.

[[gnu::cold, gnu::noinline]] timespec in_seconds(Duration time)
{
    const auto whole = std::chrono::floor<std::chrono::seconds>(time);
    return {.tv_sec = whole.count(), .tv_nsec = (time - whole).count()};
}

/// `polled` has room for all of them; ppoll does not read `revents`.
[[gnu::always_inline]] inline void poll_all(pollfd* polled, std::span<const Handle> handles, Duration left)
{
    for (std::size_t i = 0; i < handles.size(); ++i) {
        polled[i].fd = handles[i].fd; // ppoll passes over negative ones
        polled[i].events = static_cast<short>(POLLIN + POLLOUT * static_cast<int>(handles[i].wants_write));
    }
    timespec limit{.tv_sec = 0, .tv_nsec = std::max(left, Duration::zero()).count()};
    if (left >= std::chrono::seconds(1)) [[unlikely]]
        limit = in_seconds(left);
    // A signal ends the wait early, which the contract allows: the caller looks at its deadline anyway. Not by the
    // function of the C library, which keeps a copy of the limit because the kernel writes what is left of it there.
    static_assert(sizeof limit.tv_sec == 8 && sizeof limit.tv_nsec == 8);
    ::syscall(SYS_ppoll, polled, handles.size(), &limit, nullptr, 0);
}

/// On the stack as well, for here nothing is asked of the heap.
[[gnu::cold, gnu::noinline]] void poll_many(TimePoint now, std::span<const Handle> handles, TimePoint deadline)
{
    poll_all(static_cast<pollfd*>(::alloca(handles.size() * sizeof(pollfd))), handles, deadline - now);
}

} // namespace

TimePoint RealClock::now() const
{
    timespec t;
    ::clock_gettime(CLOCK_MONOTONIC, &t);
    return TimePoint{std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec}};
}

void RealClock::wait_since(TimePoint now, std::span<const Handle> handles, TimePoint deadline)
{
    constexpr std::size_t few = 32;
    if (handles.size() > few) [[unlikely]]
        return poll_many(now, handles, deadline);
    std::array<pollfd, few> polled;
    poll_all(polled.data(), handles, deadline - now);
}

} // namespace sinew::link
