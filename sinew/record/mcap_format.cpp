#include "sinew/record/mcap_format.hpp"

#include "sinew/record/crc32.hpp"

namespace sinew::record::mcap {
namespace {

constexpr std::size_t length_size = 4; // of texts, maps and arrays

} // namespace

const std::string* Channel::find(std::string_view key) const
{
    for (const auto& [name, value] : metadata)
        if (name == key)
            return &value;
    return nullptr;
}

void put_text(std::string& out, std::string_view text)
{
    put_number(out, text.size(), length_size);
    out += text;
}

void put_pairs(std::string& out, const Pairs& pairs)
{
    std::string inside;
    for (const auto& [key, value] : pairs) {
        put_text(inside, key);
        put_text(inside, value);
    }
    put_text(out, inside);
}

void put_record(std::string& out, Opcode opcode, std::string_view content)
{
    put_number(out, static_cast<std::uint8_t>(opcode), 1);
    put_number(out, content.size(), 8);
    out += content;
}

void set_record_length(std::string& out, std::size_t start)
{
    const std::uint64_t length = out.size() - start - record_head;
    for (std::size_t i = 0; i < 8; ++i)
        out[start + 1 + i] = static_cast<char>(length >> (8 * i) & 0xFF);
}

void put_schema(std::string& out, const Schema& schema)
{
    std::string content;
    put_number(content, schema.id, 2);
    put_text(content, schema.name);
    put_text(content, schema.encoding);
    put_text(content, schema.data);
    put_record(out, Opcode::schema, content);
}

void put_channel(std::string& out, const Channel& channel)
{
    std::string content;
    put_number(content, channel.id, 2);
    put_number(content, channel.schema_id, 2);
    put_text(content, channel.topic);
    put_text(content, channel.message_encoding);
    put_pairs(content, channel.metadata);
    put_record(out, Opcode::channel, content);
}

std::span<const std::uint8_t> Fields::take(std::uint64_t size)
{
    if (!good_ || size > rest_.size()) {
        good_ = false;
        rest_ = {};
        return {};
    }
    const auto out = rest_.first(static_cast<std::size_t>(size));
    rest_ = rest_.subspan(static_cast<std::size_t>(size));
    return out;
}

Pairs Fields::pairs()
{
    Pairs out;
    Fields inside(bytes(length_size));
    while (inside.good() && !inside.rest().empty()) {
        auto key = inside.text();
        auto value = inside.text();
        out.emplace_back(std::move(key), std::move(value));
    }
    good_ = good_ && inside.good();
    return out;
}

std::optional<Schema> read_schema(std::span<const std::uint8_t> content)
{
    Fields in(content);
    Schema out{.id = static_cast<std::uint16_t>(in.number(2)), .name = in.text(), .encoding = in.text()};
    out.data = in.text();
    return in.good() && out.id != 0 ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Channel> read_channel(std::span<const std::uint8_t> content)
{
    Fields in(content);
    Channel out{.id = static_cast<std::uint16_t>(in.number(2)), .schema_id = static_cast<std::uint16_t>(in.number(2))};
    out.topic = in.text();
    out.message_encoding = in.text();
    out.metadata = in.pairs();
    return in.good() ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Metadata> read_metadata(std::span<const std::uint8_t> content)
{
    Fields in(content);
    Metadata out{.name = in.text(), .pairs = in.pairs()};
    return in.good() ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<Attachment> read_attachment(std::span<const std::uint8_t> content)
{
    Fields in(content);
    Attachment out{.log_time_ns = in.number(8), .create_time_ns = in.number(8)};
    out.name = in.text();
    out.media_type = in.text();
    out.data = std::string(text_of(in.bytes(8)));
    const std::size_t covered = content.size() - in.rest().size();
    const auto crc = in.number(4);
    const bool fits = in.good() && (crc == 0 || crc == crc32(content.first(covered)));
    return fits ? std::optional(std::move(out)) : std::nullopt;
}

} // namespace sinew::record::mcap
