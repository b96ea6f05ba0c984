#include "sinew/link/descriptor.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sinew::link {
void Fd::close()
{
    if (fd_ >= 0)
        ::close(std::exchange(fd_, -1));
}

Descriptor::Descriptor(Fd fd, std::string name, const Clock& clock)
    : fd_(std::move(fd)), name_(std::move(name)), clock_(&clock)
{
    struct stat kind{};
    is_socket_ = ::fstat(fd_.get(), &kind) == 0 && S_ISSOCK(kind.st_mode);
}

std::expected<std::size_t, Error> Descriptor::write(std::span<const std::uint8_t> bytes)
{
    if (!fd_)
        return lost();
    if (bytes.empty())
        return 0;
    for (;;) {
        // A socket whose other end went away would raise SIGPIPE.
        const ssize_t count = is_socket_ ? ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                         : ::write(fd_.get(), bytes.data(), bytes.size());
        if (count >= 0)
            return static_cast<std::size_t>(count);
        if (errno == EAGAIN || errno == EWOULDBLOCK)
            return 0;
        if (errno != EINTR)
            return hang_up(std::strerror(errno));
    }
}

std::expected<Arrival, Error> Descriptor::read(std::span<std::uint8_t> into)
{
    if (!fd_)
        return lost();
    if (into.empty())
        return Arrival{.count = 0, .at = clock_->now()};
    for (;;) {
        const ssize_t count = ::read(fd_.get(), into.data(), into.size());
        if (count > 0)
            return Arrival{.count = static_cast<std::size_t>(count), .at = clock_->now()};
        if (count == 0)
            return hang_up("the other end closed");
        if (errno == EAGAIN || errno == EWOULDBLOCK)
            return Arrival{.count = 0, .at = clock_->now()};
        if (errno != EINTR)
            return hang_up(std::strerror(errno));
    }
}

std::unexpected<Error> Descriptor::hang_up(std::string_view why)
{
    fd_.close();
    why_ = why;
    return lost();
}

std::unexpected<Error> Descriptor::lost() const
{
    return fail(Errc::link_lost, fmt::format("{} hung up ({}); is it plugged in and powered?", name_, why_));
}

} // namespace sinew::link
