#pragma once
#include "sinew/record/captured.hpp"
#include "sinew/record/whole_file.hpp"

#include <filesystem>
#include <fstream>
#include <istream>
#include <memory>

namespace sinew::record {

/// A recording that is read from a file, whatever its format: its first bytes tell. Errors carry the name of the file.
class FileReader
{
public:
    /// "-" is stdin. `bad_file` where it cannot be opened.
    static std::expected<FileReader, Error> open(const std::string& path);

    /// As `Reader::next`, without feeding.
    std::expected<std::optional<Captured>, Error> next();

private:
    FileReader(std::string path, std::unique_ptr<std::ifstream> file) : path_(std::move(path)), file_(std::move(file))
    {
    }
    void fill();

    std::string path_;
    std::unique_ptr<std::ifstream> file_; // nullptr: stdin
    std::unique_ptr<Reader> reader_;
    bool over_ = false;
};

/// A recording that is written as it happens: what was added is in the file after `flush`, whatever becomes of the
/// program. Where a disk is full the file ends with the last frame that is whole.
class FileWriter
{
public:
    /// The ending tells the format: `.log` is candump's, `.pcapng` is pcapng, `.mcap` is MCAP; a file that is there is
    /// written over. `bad_argument` for other endings and where it cannot be written.
    static std::expected<FileWriter, Error> create(const std::filesystem::path& path);
    /// Finishes; what then goes wrong is not told.
    ~FileWriter();
    FileWriter(FileWriter&&) noexcept = default;
    FileWriter& operator=(FileWriter&&) = delete;

    std::expected<void, Error> add(const Captured& captured);
    std::expected<void, Error> flush();
    /// Nothing is added after it.
    std::expected<void, Error> finish();
    const std::filesystem::path& path() const { return file_.path(); }

private:
    FileWriter(std::unique_ptr<Writer> writer, WholeFile file) : writer_(std::move(writer)), file_(std::move(file)) {}
    std::expected<void, Error> write();

    std::unique_ptr<Writer> writer_; // nullptr: finished, broken or moved from
    WholeFile file_;
    std::string pending_;
};

} // namespace sinew::record
