#pragma once
#include "sinew/record/captured.hpp"

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
/// program.
class FileWriter
{
public:
    /// The ending tells the format: `.log` is candump's, `.pcapng` is pcapng; a file that is there is written over.
    /// `bad_argument` for other endings and where it cannot be written.
    static std::expected<FileWriter, Error> create(const std::filesystem::path& path);

    std::expected<void, Error> add(const Captured& captured);
    std::expected<void, Error> flush();
    const std::filesystem::path& path() const { return path_; }

private:
    FileWriter(std::filesystem::path path, std::unique_ptr<Writer> writer, std::ofstream file)
        : path_(std::move(path)), writer_(std::move(writer)), file_(std::move(file))
    {
    }

    std::filesystem::path path_;
    std::unique_ptr<Writer> writer_;
    std::ofstream file_;
    std::string pending_;
};

} // namespace sinew::record
