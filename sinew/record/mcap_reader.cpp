#include "sinew/record/mcap_reader.hpp"

#include "sinew/record/crc32.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace sinew::record::mcap {
namespace {

constexpr std::string_view cut_words = "the file ends inside this record; all whole ones before it were read";

} // namespace

std::unexpected<Error> Reader::failed(std::string_view what) const
{
    return fail(Errc::bad_file, fmt::format("offset {}: {}", here_, what));
}

const Schema* Reader::schema(std::uint16_t id) const
{
    const auto found = schemas_.find(id);
    return found == schemas_.end() ? nullptr : &found->second;
}

void Reader::feed(Bytes bytes)
{
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::exchange(at_, 0)));
    if (stage_ != Stage::broken && stage_ != Stage::over)
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

/// What is left at the end of a file that was cut off: the whole records of a chunk can still be used.
std::expected<std::optional<Reader::Record>, std::string> Reader::cut_off(Bytes rest)
{
    if (!ended_)
        return std::nullopt;
    if (stage_ == Stage::data && rest.size() > record_head && rest[0] == static_cast<std::uint8_t>(Opcode::chunk)) {
        at_ = bytes_.size();
        stage_ = Stage::broken;
        if (auto entered = enter_chunk(rest.subspan(record_head), false); !entered)
            return std::unexpected(std::string(cut_words));
        return Record{.opcode = Opcode::chunk};
    }
    if (rest.empty())
        return std::unexpected("the file ends without the record that ends its data; all before that was read");
    return std::unexpected(std::string(cut_words));
}

std::expected<std::optional<Reader::Record>, std::string> Reader::next_record()
{
    const Bytes rest = std::span(bytes_).subspan(at_);
    here_ = offset_;
    if (stage_ == Stage::first_magic || stage_ == Stage::last_magic) {
        const auto known = std::min(rest.size(), magic.size());
        if (!std::ranges::equal(rest.first(known), bytes_of(magic).first(known)))
            return std::unexpected(stage_ == Stage::first_magic ? "this is no MCAP file"
                                                                : "the file does not end as it must");
        if (known < magic.size()) {
            if (!ended_)
                return std::nullopt;
            return std::unexpected(stage_ == Stage::first_magic ? "this is no MCAP file" : std::string(cut_words));
        }
        at_ += magic.size();
        offset_ += magic.size();
        is_mcap_ = true;
        stage_ = stage_ == Stage::first_magic ? Stage::data : Stage::over;
        return next_record();
    }
    if (stage_ == Stage::over)
        return std::nullopt;
    if (rest.size() < record_head)
        return cut_off(rest);
    const std::uint64_t size = get_number(rest.subspan(1, 8));
    if (size > longest_record)
        return std::unexpected(fmt::format("a record cannot be {} bytes long", size));
    if (rest.size() - record_head < size)
        return cut_off(rest);
    at_ += record_head + size;
    offset_ += record_head + size;
    return Record{static_cast<Opcode>(rest[0]), rest.subspan(record_head, size)};
}

std::expected<void, std::string> Reader::enter_chunk(Bytes content, bool whole)
{
    Fields in(content);
    in.number(8); // its times stand in the messages
    in.number(8);
    const std::uint64_t size = in.number(8);
    const std::uint64_t crc = in.number(4);
    const auto compression = in.text();
    const std::uint64_t compressed = in.number(8);
    if (!in.good())
        return std::unexpected("a chunk that is too short");
    if (!compression.empty())
        return std::unexpected(
            fmt::format("a chunk that is compressed{}; only what is not compressed is read",
                        compression == "zstd" || compression == "lz4" ? " with " + compression : ""));
    const Bytes records = in.rest();
    if (whole && (records.size() != size || compressed != size))
        return std::unexpected(fmt::format("a chunk that says {} bytes and has {}", size, records.size()));
    if (whole && crc != 0 && crc != crc32(records))
        return std::unexpected("a chunk whose checksum does not fit; it is passed over");
    chunk_.assign(records.begin(), records.end());
    chunk_at_ = 0;
    chunk_is_cut_ = !whole;
    return {};
}

Reader::Taken Reader::next_in_chunk()
{
    const Bytes rest = std::span<const std::uint8_t>(chunk_).subspan(chunk_at_);
    const std::uint64_t size = rest.size() < record_head ? 0 : get_number(rest.subspan(1, 8));
    if (rest.size() < record_head || rest.size() - record_head < size) {
        chunk_at_ = chunk_.size();
        return std::unexpected(chunk_is_cut_ ? std::string(cut_words) : "a record that is longer than its chunk");
    }
    chunk_at_ += record_head + size;
    const auto opcode = static_cast<Opcode>(rest[0]);
    if (opcode != Opcode::message && opcode != Opcode::schema && opcode != Opcode::channel)
        return std::unexpected(fmt::format("a record of kind {} inside a chunk", rest[0]));
    return use({opcode, rest.subspan(record_head, size)});
}

template <class T>
Reader::Taken Reader::keep(std::map<std::uint16_t, T>& known, std::optional<T> read, std::string_view what)
{
    if (!read)
        return std::unexpected(fmt::format("a {} that is too short", what));
    const auto id = read->id;
    const auto [place, is_new] = known.try_emplace(id, std::move(*read));
    if (!is_new && read && !(place->second == *read))
        return std::unexpected(fmt::format("{} {} is described twice, and differs", what, id));
    return std::nullopt;
}

Reader::Taken Reader::read_message(Bytes content)
{
    constexpr std::size_t fixed = 22;
    if (content.size() < fixed)
        return std::unexpected("a message that is too short");
    Fields in(content);
    const auto id = static_cast<std::uint16_t>(in.number(2));
    const Stamp stamp{.sequence = static_cast<std::uint32_t>(in.number(4)),
                      .log_time_ns = in.number(8),
                      .publish_time_ns = in.number(8)};
    const auto channel = channels_.find(id);
    if (channel == channels_.end())
        return std::unexpected(fmt::format("a message of channel {}, of which there is no description", id));
    return Message{.channel = &channel->second, .stamp = stamp, .data = in.rest()};
}

Reader::Taken Reader::use(const Record& record)
{
    switch (record.opcode) {
    case Opcode::schema:
        return keep(schemas_, read_schema(record.content), "schema");
    case Opcode::channel:
        return keep(channels_, read_channel(record.content), "channel");
    case Opcode::message:
        return read_message(record.content);
    case Opcode::chunk:
        if (auto entered = enter_chunk(record.content, true); !entered)
            return std::unexpected(entered.error());
        return std::nullopt;
    case Opcode::attachment:
        if (auto attachment = read_attachment(record.content))
            return Item{*std::move(attachment)};
        return std::unexpected("an attachment that is damaged");
    case Opcode::metadata:
        if (auto metadata = read_metadata(record.content))
            return Item{*std::move(metadata)};
        return std::unexpected("metadata that are too short");
    case Opcode::data_end:
        stage_ = Stage::summary;
        return std::nullopt;
    default: // indexes, and what later versions may add
        return std::nullopt;
    }
}

std::expected<std::optional<Item>, Error> Reader::next()
{
    for (;;) {
        if (chunk_at_ < chunk_.size()) {
            auto taken = next_in_chunk();
            if (!taken)
                return failed(taken.error());
            if (*taken)
                return *std::move(taken);
            continue;
        }
        if (std::exchange(chunk_is_cut_, false))
            return failed(cut_words);
        if (stage_ == Stage::broken || stage_ == Stage::over)
            return std::nullopt;
        const auto record = next_record();
        if (!record) {
            stage_ = Stage::broken;
            return failed(record.error());
        }
        if (!*record)
            return std::nullopt;
        if ((*record)->opcode == Opcode::chunk && (*record)->content.data() == nullptr)
            continue; // cut off, and entered
        if (stage_ == Stage::summary) {
            if ((*record)->opcode == Opcode::footer)
                stage_ = Stage::last_magic;
            continue;
        }
        auto taken = use(**record);
        if (!taken)
            return failed(taken.error());
        if (*taken)
            return *std::move(taken);
    }
}

} // namespace sinew::record::mcap
