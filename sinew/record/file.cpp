#include "sinew/record/file.hpp"

#include "sinew/record/candump.hpp"
#include "sinew/record/mcap_frames.hpp"
#include "sinew/record/pcapng.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <iostream>

namespace sinew::record {
namespace {

constexpr std::array<std::uint8_t, 4> pcapng_start{0x0A, 0x0D, 0x0D, 0x0A};
constexpr std::array<std::uint8_t, 4> mcap_start{0x89, 'M', 'C', 'A'};
constexpr std::size_t chunk = 64 * 1024;

} // namespace

std::expected<FileReader, Error> FileReader::open(const std::string& path)
{
    if (path == "-")
        return FileReader("stdin", nullptr);
    std::error_code none;
    if (std::filesystem::is_directory(path, none))
        return fail(Errc::bad_file, fmt::format("{} is a folder and no recording", path));
    auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
    if (!*file)
        return fail(Errc::bad_file,
                    fmt::format("{} cannot be read: {}", path.empty() ? "''" : path, std::strerror(errno)));
    return FileReader(path, std::move(file));
}

void FileReader::fill()
{
    std::istream& in = file_ ? static_cast<std::istream&>(*file_) : std::cin;
    std::array<char, chunk> buffer;
    // What is there is enough: a pipe must not wait for a full buffer. The first read has to tell the format.
    in.read(buffer.data(), reader_ ? 1 : pcapng_start.size());
    auto size = static_cast<std::size_t>(in.gcount());
    if (in)
        size += static_cast<std::size_t>(
            in.readsome(buffer.data() + size, static_cast<std::streamsize>(buffer.size() - size)));
    const auto bytes = std::span(reinterpret_cast<const std::uint8_t*>(buffer.data()), size);
    if (!reader_) {
        const auto begins_with = [&](std::span<const std::uint8_t> start) {
            return size >= start.size() && std::ranges::equal(bytes.first(start.size()), start);
        };
        if (begins_with(pcapng_start))
            reader_ = std::make_unique<PcapngReader>();
        else if (begins_with(mcap_start))
            reader_ = std::make_unique<McapFrameReader>();
        else
            reader_ = std::make_unique<CandumpReader>();
    }
    reader_->feed(bytes);
    over_ = !in;
    if (over_)
        reader_->end();
}

std::expected<std::optional<Captured>, Error> FileReader::next()
{
    for (;;) {
        auto one = reader_ ? reader_->next() : std::expected<std::optional<Captured>, Error>{std::nullopt};
        if (!one)
            return fail(one.error().code, fmt::format("{}, {}", path_, one.error().detail));
        if (*one || over_)
            return one;
        fill();
    }
}

std::expected<FileWriter, Error> FileWriter::create(const std::filesystem::path& path)
{
    std::unique_ptr<Writer> writer;
    if (path.extension() == ".log")
        writer = std::make_unique<CandumpWriter>();
    else if (path.extension() == ".pcapng")
        writer = std::make_unique<PcapngWriter>();
    else if (path.extension() == ".mcap")
        writer = std::make_unique<McapFrameWriter>();
    else
        return fail(
            Errc::bad_argument,
            fmt::format("'{}' must end with .mcap, .pcapng (Wireshark) or .log (candump, CAN only)", path.string()));
    auto file = WholeFile::create(path);
    if (!file)
        return std::unexpected(file.error());
    return FileWriter(std::move(writer), std::move(*file));
}

FileWriter::~FileWriter()
{
    if (writer_)
        (void)finish();
}

std::expected<void, Error> FileWriter::add(const Captured& captured)
{
    if (!writer_)
        return fail(Errc::bad_argument, fmt::format("{} takes nothing more", path().string()));
    if (auto added = writer_->add(captured, pending_); !added)
        return added;
    return pending_.size() >= chunk ? write() : std::expected<void, Error>{};
}

std::expected<void, Error> FileWriter::write()
{
    auto written = file_.append(pending_);
    pending_.clear();
    if (!written)
        writer_.reset(); // what would follow stands at the wrong place
    return written;
}

std::expected<void, Error> FileWriter::flush()
{
    if (writer_)
        writer_->flush(pending_);
    return write();
}

std::expected<void, Error> FileWriter::finish()
{
    if (!writer_)
        return {};
    writer_->finish(pending_);
    auto written = write();
    writer_.reset();
    return written;
}

} // namespace sinew::record
