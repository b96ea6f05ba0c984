#include "sinew/link/descriptor.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sys/stat.h>

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

/// What a write that took nothing means.
std::expected<std::size_t, Error> Descriptor::write_nothing(int problem)
{
    if (!fd_)
        return lost();
    if (problem == EAGAIN || problem == EWOULDBLOCK || problem == EINTR)
        return 0;
    return hang_up(std::strerror(problem));
}

/// What a read without bytes means: `count` as the system returned it, so 0 for an end of file unless none were asked
/// for.
std::expected<Arrival, Error> Descriptor::read_nothing(ssize_t count, std::size_t asked)
{
    const int problem = count != 0 ? errno : asked == 0 ? EAGAIN : 0;
    if (!fd_)
        return lost();
    if (problem == EAGAIN || problem == EWOULDBLOCK || problem == EINTR)
        return Arrival{};
    return hang_up(problem == 0 ? "the other end closed" : std::strerror(problem));
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
