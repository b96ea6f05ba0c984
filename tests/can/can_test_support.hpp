#pragma once
#include "sinew/link/socketcan.hpp"

#include <chrono>
#include <cstdlib>
#include <gtest/gtest.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <string>
#include <sys/ioctl.h>

/// What the tests on the kernel's CAN stack share. They own the machine: interfaces are made and removed as root.
namespace sinew::link::test {

using namespace std::chrono_literals;

inline constexpr Duration patience = 5s; ///< only a test that fails waits so long

inline void shell(const std::string& command)
{
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

/// As `ip link set INTERFACE up`, or down; to start a program takes a guest a quarter of a second.
inline void set_up(const std::string& interface, bool up)
{
    const Fd any(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
    ifreq request{};
    interface.copy(request.ifr_name, sizeof request.ifr_name - 1);
    ASSERT_EQ(::ioctl(any.get(), SIOCGIFFLAGS, &request), 0);
    const int others = request.ifr_flags & ~IFF_UP;
    request.ifr_flags = static_cast<short>(up ? others | IFF_UP : others);
    ASSERT_EQ(::ioctl(any.get(), SIOCSIFFLAGS, &request), 0);
}

inline std::unique_ptr<SocketCanLink> open(const SocketCanOptions& options, const Clock& clock)
{
    auto link = SocketCanLink::open(options, clock);
    EXPECT_TRUE(link) << to_sentence(link.error());
    return link ? std::move(*link) : nullptr;
}

inline wire::Frame frame(std::uint32_t id, std::uint8_t first = 0)
{
    return {.can_id = id, .size = 8, .data = {first, 1, 2, 3, 4, 5, 6, 7}};
}

/// Somebody else's program on the interface: a plain socket that sends anything.
class PlainSocket
{
public:
    explicit PlainSocket(const std::string& interface) : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW))
    {
        const auto found = can_interface(interface);
        EXPECT_TRUE(found);
        const sockaddr_can address{.can_family = AF_CAN, .can_ifindex = found ? found->index : 0};
        EXPECT_EQ(::bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    void send(std::uint32_t can_id, std::array<std::uint8_t, 8> data = {})
    {
        can_frame frame{.can_id = can_id, .len = 8};
        std::ranges::copy(data, frame.data);
        EXPECT_EQ(::write(fd_.get(), &frame, sizeof frame), static_cast<ssize_t>(sizeof frame));
    }

private:
    Fd fd_;
};

/// Reads until that many frames have come; fewer when patience ran out or the link was lost.
inline std::vector<wire::Frame> read(SocketCanLink& link, Clock& clock, std::size_t count)
{
    std::vector<wire::Frame> frames;
    const TimePoint deadline = clock.now() + patience;
    while (frames.size() < count && clock.now() < deadline) {
        wire::Frame one;
        const auto arrival = link.read({&one, 1});
        if (!arrival)
            return frames;
        if (arrival->count != 0) {
            frames.push_back(one);
            continue;
        }
        const Handle handles[] = {{.fd = link.handle()}};
        clock.wait(handles, deadline);
    }
    return frames;
}

/// Whether nothing is there to be read: asked twice, for a link may pass over the first look.
inline bool is_silent(SocketCanLink& link)
{
    wire::Frame one;
    for (int look = 0; look < 2; ++look) {
        const auto arrival = link.read({&one, 1});
        if (!arrival || arrival->count != 0)
            return false;
    }
    return true;
}

/// The error that reading ends with; patience running out gives none. `waits` tells how often it had to wait.
inline std::optional<Error> read_until_error(SocketCanLink& link, Clock& clock)
{
    const TimePoint deadline = clock.now() + patience;
    while (clock.now() < deadline) {
        wire::Frame one;
        const auto arrival = link.read({&one, 1});
        if (!arrival)
            return arrival.error();
        const Handle handles[] = {{.fd = link.handle()}};
        if (arrival->count == 0)
            clock.wait(handles, deadline);
    }
    return std::nullopt;
}

} // namespace sinew::link::test
