#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"

#include <cerrno>
#include <string>
#include <sys/socket.h>
#include <unistd.h>
#include <utility>

namespace sinew::link {

/// Owns one descriptor of the operating system.
class Fd
{
public:
    Fd() = default;
    explicit Fd(int fd) : fd_(fd) {}
    Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Fd& operator=(Fd&& other) noexcept
    {
        std::swap(fd_, other.fd_);
        return *this;
    }
    ~Fd() { close(); }

    int get() const { return fd_; }
    explicit operator bool() const { return fd_ >= 0; }
    void close();

private:
    int fd_ = -1;
};

/// Bytes through a non-blocking descriptor, the common part of the links of the operating system. Anything but "not
/// now" counts as a hang-up: the descriptor is closed at once, so that a device that is plugged in again gets its old
/// name, and every later call says `link_lost`.
class Descriptor
{
public:
    /// `name` is how messages call the link. The clock must outlive the descriptor.
    Descriptor(Fd fd, std::string name, const Clock& clock);

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes)
    {
        // A socket whose other end went away would raise SIGPIPE.
        const ssize_t count = is_socket_ ? ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                         : ::write(fd_.get(), bytes.data(), bytes.size());
        if (count > 0) [[likely]]
            return std::expected<std::size_t, Error>{std::in_place, static_cast<std::size_t>(count)};
        return write_nothing(count == 0 ? EAGAIN : errno);
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into)
    {
        const ssize_t count = ::read(fd_.get(), into.data(), into.size());
        if (count > 0) [[likely]]
            return std::expected<Arrival, Error>{std::in_place, static_cast<std::size_t>(count), clock_->now(), false};
        if (count < 0 && errno == EAGAIN)
            return std::expected<Arrival, Error>{std::in_place, 0U, TimePoint{}, false};
        return read_nothing(count, into.size());
    }
    int fd() const { return fd_.get(); }
    bool is_open() const { return static_cast<bool>(fd_); }
    /// Closes, for the reason in `why`, and returns the `link_lost` that all later calls return.
    std::unexpected<Error> hang_up(std::string_view why);

private:
    std::expected<std::size_t, Error> write_nothing(int problem);
    std::expected<Arrival, Error> read_nothing(ssize_t count, std::size_t asked);
    std::unexpected<Error> lost() const;

    Fd fd_;
    std::string name_;
    const Clock* clock_;
    bool is_socket_;
    std::string why_;
};

} // namespace sinew::link
