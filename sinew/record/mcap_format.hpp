#pragma once
#include "sinew/record/little_endian.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What MCAP files are made of. A file is the magic, records (an opcode, a length of eight bytes, the content), and the
/// magic again: first the data section (messages in chunks, attachments, metadata), then a summary that says where
/// everything stands. Source: the MCAP format specification, version 0.
namespace sinew::record::mcap {

inline constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t record_head = 9; ///< opcode and length

enum class Opcode : std::uint8_t {
    header = 0x01,
    footer = 0x02,
    schema = 0x03,
    channel = 0x04,
    message = 0x05,
    chunk = 0x06,
    message_index = 0x07,
    chunk_index = 0x08,
    attachment = 0x09,
    attachment_index = 0x0A,
    statistics = 0x0B,
    metadata = 0x0C,
    metadata_index = 0x0D,
    summary_offset = 0x0E,
    data_end = 0x0F,
};

using Pairs = std::vector<std::pair<std::string, std::string>>;

struct Schema {
    std::uint16_t id = 0;
    std::string name;
    std::string encoding;
    std::string data;

    friend bool operator==(const Schema&, const Schema&) = default;
};

struct Channel {
    std::uint16_t id = 0;
    std::uint16_t schema_id = 0; ///< 0: none
    std::string topic;
    std::string message_encoding;
    Pairs metadata;

    const std::string* find(std::string_view key) const; ///< in `metadata`; nullptr: not there
    friend bool operator==(const Channel&, const Channel&) = default;
};

struct Attachment {
    std::uint64_t log_time_ns = 0;
    std::uint64_t create_time_ns = 0;
    std::string name;
    std::string media_type;
    std::string data;

    friend bool operator==(const Attachment&, const Attachment&) = default;
};

struct Metadata {
    std::string name;
    Pairs pairs;

    friend bool operator==(const Metadata&, const Metadata&) = default;
};

// ---- writing ----

void put_text(std::string& out, std::string_view text);
void put_pairs(std::string& out, const Pairs& pairs);
/// A record with this content.
void put_record(std::string& out, Opcode opcode, std::string_view content);
/// The length of a record whose content follows it in `out`, at `start` of the record.
void set_record_length(std::string& out, std::size_t start);

void put_schema(std::string& out, const Schema& schema);
void put_channel(std::string& out, const Channel& channel);

// ---- reading ----

/// Takes fields from the front of a content. Once there are too few bytes, everything is empty and `good` is false.
class Fields
{
public:
    explicit Fields(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

    bool good() const { return good_; }
    std::uint64_t number(std::size_t size) { return get_number(take(size)); }
    std::string text() { return std::string(text_of(take(number(4)))); }
    std::span<const std::uint8_t> bytes(std::size_t length_size) { return take(number(length_size)); }
    std::span<const std::uint8_t> rest() const { return rest_; }
    Pairs pairs();

private:
    std::span<const std::uint8_t> take(std::uint64_t size);

    std::span<const std::uint8_t> rest_;
    bool good_ = true;
};

/// Nothing where the content is too short.
std::optional<Schema> read_schema(std::span<const std::uint8_t> content);
std::optional<Channel> read_channel(std::span<const std::uint8_t> content);
std::optional<Metadata> read_metadata(std::span<const std::uint8_t> content);
/// Nothing as well where its checksum does not fit.
std::optional<Attachment> read_attachment(std::span<const std::uint8_t> content);

} // namespace sinew::record::mcap
