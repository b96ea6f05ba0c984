#pragma once
#include "sinew/link/link.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <linux/can.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <string>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

/// The far end of a real descriptor in a process of its own: a device that answers every request with the same bytes,
/// or on a socket that stands in for CAN every frame with itself and another last byte.
namespace sinew::support {

class Peer
{
public:
    /// A device behind a pseudo terminal: after `request_size` bytes it writes `reply`, `after` later.
    static Peer on_pty(std::size_t request_size, std::span<const std::uint8_t> reply, Duration after = {})
    {
        Peer peer;
        const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
        if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0)
            std::abort();
        peer.device = ::ptsname(master);
        termios raw{};
        ::tcgetattr(master, &raw);
        ::cfmakeraw(&raw);
        ::tcsetattr(master, TCSANOW, &raw);
        peer.child_ = ::fork();
        if (peer.child_ == 0 && ::open(peer.device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC) < 0)
            ::_exit(1); // held open, so that a read waits for bytes also while nobody else has the line
        if (peer.child_ == 0)
            answer_bytes(master, request_size, reply, after);
        peer.held_ = master;
        return peer;
    }
    /// A device behind one end of a SEQPACKET socket pair: echoes each packet with its last byte set to 1.
    static Peer on_socket()
    {
        Peer peer;
        std::array<int, 2> ends{};
        if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
            std::abort();
        peer.child_ = ::fork();
        if (peer.child_ == 0) {
            ::close(ends[0]);
            answer_frames(ends[1]);
        }
        ::close(ends[1]);
        peer.fd = ends[0];
        ::fcntl(peer.fd, F_SETFL, O_NONBLOCK);
        return peer;
    }
    ~Peer()
    {
        if (child_ > 0) {
            ::kill(child_, SIGKILL);
            ::waitpid(child_, nullptr, 0);
        }
        if (held_ >= 0)
            ::close(held_);
    }
    Peer(Peer&& other) noexcept
        : device(std::move(other.device)), fd(other.fd), child_(std::exchange(other.child_, -1)),
          held_(std::exchange(other.held_, -1))
    {
    }
    Peer& operator=(Peer&&) = delete;

    /// Lets the device run on one processor only.
    void bind_to(int processor) const
    {
        cpu_set_t only;
        CPU_ZERO(&only);
        CPU_SET(processor, &only);
        if (::sched_setaffinity(child_, sizeof only, &only) != 0)
            std::abort();
    }

    /// Lets the device and this program run on one processor, where neither interrupts the other.
    void take_turns() const
    {
        const int here = ::sched_getcpu();
        const sched_param none{};
        cpu_set_t only;
        CPU_ZERO(&only);
        CPU_SET(here, &only);
        for (const pid_t process : {child_, ::getpid()})
            if (::sched_setaffinity(process, sizeof only, &only) != 0 ||
                ::sched_setscheduler(process, SCHED_BATCH, &none) != 0)
                std::abort();
    }

    std::string device; ///< of the pseudo terminal
    int fd = -1;        ///< of the socket; whoever takes it closes it

private:
    Peer() = default;

    [[noreturn]] static void answer_bytes(int fd, std::size_t request_size, std::span<const std::uint8_t> reply,
                                          Duration after)
    {
        std::array<std::uint8_t, 256> heard;
        for (std::size_t count = 0;;) {
            const ssize_t got = ::read(fd, heard.data(), heard.size());
            if (got <= 0)
                ::_exit(1);
            for (count += static_cast<std::size_t>(got); count >= request_size; count -= request_size) {
                if (after > Duration{}) { // the time that the device itself takes
                    const timespec t{.tv_sec = 0, .tv_nsec = after.count()};
                    ::nanosleep(&t, nullptr);
                }
                if (::write(fd, reply.data(), reply.size()) < 0)
                    ::_exit(1);
            }
        }
    }
    [[noreturn]] static void answer_frames(int fd)
    {
        constexpr unsigned batch = 64;
        static std::array<can_frame, batch> frames;
        static std::array<iovec, batch> places;
        static std::array<mmsghdr, batch> messages;
        for (unsigned i = 0; i < batch; ++i) {
            places[i] = {&frames[i], sizeof frames[i]};
            messages[i].msg_hdr.msg_iov = &places[i];
            messages[i].msg_hdr.msg_iovlen = 1;
        }
        for (;;) {
            const int got = ::recvmmsg(fd, messages.data(), batch, MSG_WAITFORONE, nullptr);
            if (got <= 0)
                ::_exit(0);
            for (int i = 0; i < got; ++i)
                frames[static_cast<std::size_t>(i)].data[7] = 1;
            ::sendmmsg(fd, messages.data(), static_cast<unsigned>(got), 0);
        }
    }

    pid_t child_ = -1;
    int held_ = -1;
};

/// CAN frames over a SEQPACKET socket, in batches. Owns the descriptor.
class SocketFrames final : public link::CanLink
{
public:
    SocketFrames(int fd, const link::Clock& clock) : fd_(fd), clock_(clock)
    {
        for (std::size_t i = 0; i < batch; ++i) {
            places_[i] = {&frames_[i], sizeof frames_[i]};
            messages_[i].msg_hdr.msg_iov = &places_[i];
            messages_[i].msg_hdr.msg_iovlen = 1;
        }
    }
    ~SocketFrames() override { ::close(fd_); }

    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        const std::size_t count = std::min(frames.size(), batch);
        for (std::size_t i = 0; i < count; ++i) {
            frames_[i].can_id = frames[i].can_id;
            frames_[i].len = frames[i].size;
            std::memcpy(frames_[i].data, frames[i].data.data(), sizeof frames_[i].data);
        }
        const int sent = ::sendmmsg(fd_, messages_.data(), static_cast<unsigned>(count), MSG_NOSIGNAL);
        return sent < 0 ? 0U : static_cast<std::size_t>(sent);
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override
    {
        const std::size_t most = std::min(into.size(), batch);
        const int got = ::recvmmsg(fd_, messages_.data(), static_cast<unsigned>(most), MSG_DONTWAIT, nullptr);
        const std::size_t count = got < 0 ? 0 : static_cast<std::size_t>(got);
        for (std::size_t i = 0; i < count; ++i) {
            into[i].can_id = frames_[i].can_id;
            into[i].size = frames_[i].len;
            into[i].data.fill(0);
            std::memcpy(into[i].data.data(), frames_[i].data, sizeof frames_[i].data);
        }
        return std::expected<link::Arrival, Error>{std::in_place, count, clock_.now(), false};
    }
    int handle() const override { return fd_; }
    link::LinkState state() const override { return {.open = true, .bit_rate = 1'000'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return rate; }

private:
    static constexpr std::size_t batch = 64;
    int fd_;
    const link::Clock& clock_;
    std::array<can_frame, batch> frames_{};
    std::array<iovec, batch> places_{};
    std::array<mmsghdr, batch> messages_{};
};

} // namespace sinew::support
