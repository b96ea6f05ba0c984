#pragma once
#include "sinew/base/error.hpp"
#include "sinew/link/descriptor.hpp"

#include <expected>
#include <filesystem>
#include <string_view>

namespace sinew::record {

/// A file that grows by pieces, each of which is in it whole or not at all: where the disk is full, or a limit is
/// reached, what had come of the piece is cut off again, and a file in which nothing had room is not left behind. A
/// file that is there is written over.
///
/// A program that may reach a limit on the size of its files (RLIMIT_FSIZE) has to ignore SIGXFSZ: it kills.
class WholeFile
{
public:
    /// `bad_argument` with the system's words where it cannot be written.
    static std::expected<WholeFile, Error> create(const std::filesystem::path& path);

    ~WholeFile();
    WholeFile(WholeFile&&) noexcept = default;
    WholeFile& operator=(WholeFile&&) = delete;

    /// `bad_file` where it can take no more. A shorter piece may still fit.
    std::expected<void, Error> append(std::string_view piece);
    const std::filesystem::path& path() const { return path_; }

private:
    WholeFile(std::filesystem::path path, link::Fd fd) : path_(std::move(path)), fd_(std::move(fd)) {}

    std::filesystem::path path_;
    link::Fd fd_;
    std::uint64_t size_ = 0;
    bool refused_ = false; ///< a piece
};

} // namespace sinew::record
