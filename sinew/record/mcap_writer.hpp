#pragma once
#include "sinew/record/mcap_format.hpp"

#include <map>

namespace sinew::record::mcap {

/// What of a message is not its bytes.
struct Stamp {
    std::uint32_t sequence = 0;
    std::uint64_t log_time_ns = 0;
    std::uint64_t publish_time_ns = 0;
};

/// Puts messages into the bytes of an MCAP file: uncompressed chunks with a checksum and an index each, and a summary
/// at the end. Pure: whoever uses it writes `pending()` and then calls `written()`; `pending()` always ends where a
/// record ends, so a file that is written up to there can be read and recovered. A chunk is held back until it is full
/// or closed.
class Writer
{
public:
    static constexpr std::size_t chunk_size = 4U << 20U; ///< a chunk is closed when it has grown to this

    explicit Writer(std::string_view library = "sinew");

    /// The id of the schema or channel; the `id` in the argument does not matter. There are at most 65 535 of each.
    std::uint16_t add_schema(Schema schema);
    std::uint16_t add_channel(Channel channel);

    /// Appends the data of a message to the text that is handed to `fill`, in place.
    template <class Fill>
    void add(std::uint16_t channel, Stamp stamp, Fill&& fill)
    {
        const std::size_t start = begin_message(channel, stamp);
        fill(chunk_);
        end_message(channel, start, stamp);
    }
    void add(std::uint16_t channel, Stamp stamp, std::span<const std::uint8_t> data)
    {
        add(channel, stamp, [&](std::string& out) { out += text_of(data); });
    }
    void attach(const Attachment& attachment);
    void add(const Metadata& metadata);

    /// What was added is in `pending()`.
    void close_chunk();
    /// The summary; nothing is added after it.
    void finish();

    std::string_view pending() const { return out_; }
    void written();
    /// `pending()` cannot be written: it is forgotten, with the messages in it. Schemas and channels stay known.
    void drop_pending();
    std::uint64_t messages() const { return messages_; }
    bool has_open_chunk() const { return !chunk_.empty(); }

private:
    struct InChunk {
        std::string entries; // time and offset of each message
        std::uint64_t count = 0;
    };
    struct ChunkIndex {
        std::uint64_t start_ns, end_ns, offset, length, index_length, size;
        std::vector<std::pair<std::uint16_t, std::uint64_t>> index_offsets;
        std::vector<std::uint64_t> counts; // one for each of these
    };

    std::size_t begin_message(std::uint16_t channel, Stamp stamp);
    void end_message(std::uint16_t channel, std::size_t start, Stamp stamp);
    std::uint64_t offset() const { return gone_ + out_.size(); }
    std::string statistics() const;

    std::string out_;
    std::uint64_t gone_ = 0; // bytes before `out_`

    std::string chunk_; // its records
    std::vector<InChunk> in_chunk_;
    std::uint64_t chunk_start_ns_ = 0, chunk_end_ns_ = 0;

    std::vector<Schema> schemas_;
    std::vector<Channel> channels_;
    std::vector<ChunkIndex> chunks_;
    struct Place {
        std::uint64_t offset;
        std::string index; // its record in the summary
    };
    std::vector<Place> attachments_, metadata_;
    std::vector<std::uint64_t> counts_; // by channel
    std::uint64_t messages_ = 0;
};

} // namespace sinew::record::mcap
