#pragma once
#include "sinew/base/error.hpp"
#include "sinew/link/descriptor.hpp"

#include <expected>
#include <filesystem>
#include <string_view>

namespace sinew::cli {

/// What would be in the way of writing a file, without touching one that is there: `bad_argument` with the reason.
std::expected<void, Error> check_writable(const std::filesystem::path& path);

/// A file that comes into being whole or not at all: it is written beside its place and goes there by `keep`, over what
/// was there. Without `keep` nothing is left of it.
class NewFile
{
public:
    /// `bad_argument` with the reason where it cannot be made; `bad_file` later, where it can take no more.
    static std::expected<NewFile, Error> make(const std::filesystem::path& path);
    ~NewFile();
    NewFile(NewFile&& other) noexcept;
    NewFile& operator=(NewFile&&) = delete;

    int fd() const { return fd_.get(); }
    const std::filesystem::path& path() const { return path_; }
    std::expected<void, Error> write(std::string_view text);
    std::expected<void, Error> keep();

private:
    NewFile(std::filesystem::path path, std::filesystem::path beside, int fd);

    std::filesystem::path path_;
    std::filesystem::path beside_; ///< empty: kept, or moved from
    link::Fd fd_;
};

} // namespace sinew::cli
