#include "sinew/record/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace sinew::record {
namespace {

std::unexpected<Error> refused(Errc code, const std::filesystem::path& path, int error)
{
    return fail(code, fmt::format("{} cannot be written: {}", path.string(), std::strerror(error)));
}

} // namespace

std::expected<WholeFile, Error> WholeFile::create(const std::filesystem::path& path)
{
    link::Fd fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (fd.get() < 0)
        return refused(Errc::bad_argument, path, errno);
    return WholeFile(path, std::move(fd));
}

WholeFile::~WholeFile()
{
    struct stat it{};
    if (fd_.get() >= 0 && refused_ && size_ == 0 && ::fstat(fd_.get(), &it) == 0 && S_ISREG(it.st_mode))
        ::unlink(path_.c_str());
}

std::expected<void, Error> WholeFile::append(std::string_view piece)
{
    const std::size_t whole = piece.size();
    while (!piece.empty()) {
        const auto written = ::write(fd_.get(), piece.data(), piece.size());
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0) {
            const int error = written < 0 ? errno : ENOSPC;
            refused_ = true;
            // What is no regular file cannot be cut, and has no size.
            if (::ftruncate(fd_.get(), static_cast<off_t>(size_)) == 0)
                ::lseek(fd_.get(), static_cast<off_t>(size_), SEEK_SET);
            return refused(Errc::bad_file, path_, error);
        }
        piece.remove_prefix(static_cast<std::size_t>(written));
    }
    size_ += whole;
    return {};
}

} // namespace sinew::record
