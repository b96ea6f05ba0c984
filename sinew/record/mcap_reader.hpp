#pragma once
#include "sinew/base/error.hpp"
#include "sinew/record/mcap_writer.hpp"

#include <expected>
#include <map>
#include <variant>

namespace sinew::record::mcap {

/// A message as it is read. Valid until the reader is used again; the channel as long as the reader lives.
struct Message {
    const Channel* channel = nullptr;
    Stamp stamp;
    std::span<const std::uint8_t> data;
};

using Item = std::variant<Message, Attachment, Metadata>;

/// An MCAP file as it is read from its beginning, in pieces of any size, without its summary: so a file that was never
/// finished reads like any other. Errors are `bad_file` with the offset; go on asking, for what can be read after that
/// follows. A file that is cut off gives all whole records before the cut, those of a chunk that was cut included, then
/// the error. A chunk whose checksum does not fit, or that is compressed, is passed over with an error.
class Reader
{
public:
    static constexpr std::uint64_t longest_record = 1U << 30U;

    void feed(std::span<const std::uint8_t> bytes);
    void end() { ended_ = true; }
    /// Nothing: feed more or, after `end`, it is over.
    std::expected<std::optional<Item>, Error> next();

    const Schema* schema(std::uint16_t id) const; ///< nullptr: none
    bool is_mcap() const { return is_mcap_; }     ///< its first bytes were right
    /// Whether the end of the file was seen, so that nothing is missing.
    bool was_finished() const { return stage_ == Stage::over; }

private:
    using Bytes = std::span<const std::uint8_t>;
    enum class Stage : std::uint8_t { first_magic, data, summary, last_magic, over, broken };
    struct Record {
        Opcode opcode{};
        Bytes content;
    };
    using Taken = std::expected<std::optional<Item>, std::string>;

    std::expected<std::optional<Record>, std::string> next_record();
    std::expected<std::optional<Record>, std::string> cut_off(Bytes rest);
    Taken use(const Record& record);
    std::expected<void, std::string> enter_chunk(Bytes content, bool whole);
    Taken next_in_chunk();
    Taken read_message(Bytes content);
    template <class T>
    Taken keep(std::map<std::uint16_t, T>& known, std::optional<T> read, std::string_view what);
    std::unexpected<Error> failed(std::string_view what) const;

    Stage stage_ = Stage::first_magic;
    bool is_mcap_ = false;
    bool ended_ = false;
    std::vector<std::uint8_t> bytes_;
    std::size_t at_ = 0;
    std::uint64_t offset_ = 0; // of at_ in the file
    std::uint64_t here_ = 0;   // where the record began that is being read

    std::vector<std::uint8_t> chunk_;
    std::size_t chunk_at_ = 0;
    bool chunk_is_cut_ = false;

    std::map<std::uint16_t, Schema> schemas_;
    std::map<std::uint16_t, Channel> channels_;
};

} // namespace sinew::record::mcap
