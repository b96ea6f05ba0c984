#include "apps/cli/new_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

namespace sinew::cli {
namespace {

std::unexpected<Error> refused(Errc code, const std::filesystem::path& path, int error)
{
    return fail(code, fmt::format("{} cannot be written: {}", path.string(), std::strerror(error)));
}

} // namespace

std::expected<void, Error> check_writable(const std::filesystem::path& path)
{
    std::error_code unknown;
    const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
    if (std::filesystem::is_directory(path, unknown))
        return refused(Errc::bad_argument, path, EISDIR);
    const auto& asked = std::filesystem::exists(path, unknown) ? path : folder;
    return ::access(asked.c_str(), W_OK) == 0 ? std::expected<void, Error>{} : refused(Errc::bad_argument, path, errno);
}

NewFile::NewFile(std::filesystem::path path, std::filesystem::path beside, int fd)
    : path_(std::move(path)), beside_(std::move(beside)), fd_(fd)
{
}

NewFile::NewFile(NewFile&& other) noexcept
    : path_(std::move(other.path_)), beside_(std::exchange(other.beside_, {})), fd_(std::move(other.fd_))
{
}

NewFile::~NewFile()
{
    if (!beside_.empty())
        ::unlink(beside_.c_str());
}

std::expected<NewFile, Error> NewFile::make(const std::filesystem::path& path)
{
    std::error_code unknown;
    const auto status = std::filesystem::status(path, unknown);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        return fail(Errc::bad_argument, fmt::format("{} cannot be written: it is there and no file", path.string()));
    // A name of its own in the same folder, so that taking the place is one step.
    auto beside = path;
    beside += fmt::format(".{}.part", ::getpid());
    const int fd = ::open(beside.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0)
        return refused(Errc::bad_argument, path, errno);
    return NewFile(path, std::move(beside), fd);
}

std::expected<void, Error> NewFile::write(std::string_view text)
{
    while (!text.empty()) {
        const auto written = ::write(fd(), text.data(), text.size());
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return refused(Errc::bad_file, path_, errno);
        text.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
}

std::expected<void, Error> NewFile::keep()
{
    // What takes the place of another file must be on the disk before: a power cut would leave an empty one.
    if (::fsync(fd()) != 0 && errno != EINVAL && errno != EROFS)
        return refused(Errc::bad_file, path_, errno);
    if (::rename(beside_.c_str(), path_.c_str()) != 0)
        return refused(Errc::bad_file, path_, errno);
    beside_.clear();
    return {};
}

} // namespace sinew::cli
