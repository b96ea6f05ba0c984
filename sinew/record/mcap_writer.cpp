#include "sinew/record/mcap_writer.hpp"

#include "sinew/record/crc32.hpp"

#include <algorithm>

namespace sinew::record::mcap {
namespace {

constexpr std::uint16_t first_id = 1; // of schemas; 0 means none

} // namespace

Writer::Writer(std::string_view library)
{
    out_ = magic;
    std::string content;
    put_text(content, ""); // no profile
    put_text(content, library);
    put_record(out_, Opcode::header, content);
}

std::uint16_t Writer::add_schema(Schema schema)
{
    schema.id = static_cast<std::uint16_t>(schemas_.size() + first_id);
    put_schema(out_, schema);
    schemas_.push_back(std::move(schema));
    return schemas_.back().id;
}

std::uint16_t Writer::add_channel(Channel channel)
{
    channel.id = static_cast<std::uint16_t>(channels_.size());
    put_channel(out_, channel);
    channels_.push_back(std::move(channel));
    counts_.push_back(0);
    in_chunk_.emplace_back();
    return channels_.back().id;
}

std::size_t Writer::begin_message(std::uint16_t channel, Stamp stamp)
{
    const std::size_t start = chunk_.size();
    put_record(chunk_, Opcode::message, "");
    put_number(chunk_, channel, 2);
    put_number(chunk_, stamp.sequence, 4);
    put_number(chunk_, stamp.log_time_ns, 8);
    put_number(chunk_, stamp.publish_time_ns, 8);
    return start;
}

void Writer::end_message(std::uint16_t channel, std::size_t start, Stamp stamp)
{
    set_record_length(chunk_, start);
    InChunk& index = in_chunk_[channel];
    put_number(index.entries, stamp.log_time_ns, 8);
    put_number(index.entries, start, 8);
    ++index.count;
    chunk_start_ns_ = start == 0 ? stamp.log_time_ns : std::min(chunk_start_ns_, stamp.log_time_ns);
    chunk_end_ns_ = start == 0 ? stamp.log_time_ns : std::max(chunk_end_ns_, stamp.log_time_ns);
    ++messages_;
    ++counts_[channel];
    if (chunk_.size() >= chunk_size)
        close_chunk();
}

void Writer::close_chunk()
{
    if (chunk_.empty())
        return;
    ChunkIndex chunk{.start_ns = chunk_start_ns_,
                     .end_ns = chunk_end_ns_,
                     .offset = offset(),
                     .length = 0,
                     .index_length = 0,
                     .size = chunk_.size(),
                     .index_offsets = {},
                     .counts = {}};
    const std::size_t start = out_.size();
    put_record(out_, Opcode::chunk, "");
    put_number(out_, chunk_start_ns_, 8);
    put_number(out_, chunk_end_ns_, 8);
    put_number(out_, chunk_.size(), 8);
    put_number(out_, crc32(bytes_of(chunk_)), 4);
    put_text(out_, ""); // not compressed
    put_number(out_, chunk_.size(), 8);
    out_ += chunk_;
    set_record_length(out_, start);
    chunk.length = offset() - chunk.offset;
    for (std::size_t channel = 0; channel < in_chunk_.size(); ++channel) {
        InChunk& index = in_chunk_[channel];
        if (index.count == 0)
            continue;
        chunk.index_offsets.emplace_back(static_cast<std::uint16_t>(channel), offset());
        chunk.counts.push_back(index.count);
        const std::size_t index_start = out_.size();
        put_record(out_, Opcode::message_index, "");
        put_number(out_, channel, 2);
        put_text(out_, index.entries);
        set_record_length(out_, index_start);
        index.entries.clear();
        index.count = 0;
    }
    chunk.index_length = offset() - chunk.offset - chunk.length;
    chunks_.push_back(std::move(chunk));
    chunk_.clear();
}

void Writer::attach(const Attachment& attachment)
{
    const std::uint64_t at = offset();
    std::string content;
    put_number(content, attachment.log_time_ns, 8);
    put_number(content, attachment.create_time_ns, 8);
    put_text(content, attachment.name);
    put_text(content, attachment.media_type);
    put_number(content, attachment.data.size(), 8);
    content += attachment.data;
    put_number(content, crc32(bytes_of(content)), 4);
    put_record(out_, Opcode::attachment, content);

    std::string index;
    put_number(index, at, 8);
    put_number(index, offset() - at, 8);
    put_number(index, attachment.log_time_ns, 8);
    put_number(index, attachment.create_time_ns, 8);
    put_number(index, attachment.data.size(), 8);
    put_text(index, attachment.name);
    put_text(index, attachment.media_type);
    attachments_.push_back({at, std::move(index)});
}

void Writer::add(const Metadata& metadata)
{
    const std::uint64_t at = offset();
    std::string content;
    put_text(content, metadata.name);
    put_pairs(content, metadata.pairs);
    put_record(out_, Opcode::metadata, content);

    std::string index;
    put_number(index, at, 8);
    put_number(index, offset() - at, 8);
    put_text(index, metadata.name);
    metadata_.push_back({at, std::move(index)});
}

std::string Writer::statistics() const
{
    std::string out;
    put_number(out, messages_, 8);
    put_number(out, schemas_.size(), 2);
    put_number(out, channels_.size(), 4);
    put_number(out, attachments_.size(), 4);
    put_number(out, metadata_.size(), 4);
    put_number(out, chunks_.size(), 4);
    std::uint64_t start_ns = chunks_.empty() ? 0 : chunks_.front().start_ns, end_ns = 0;
    for (const auto& chunk : chunks_) {
        start_ns = std::min(start_ns, chunk.start_ns);
        end_ns = std::max(end_ns, chunk.end_ns);
    }
    put_number(out, start_ns, 8);
    put_number(out, end_ns, 8);
    std::string counts;
    for (std::size_t channel = 0; channel < counts_.size(); ++channel)
        if (counts_[channel] != 0) {
            put_number(counts, channel, 2);
            put_number(counts, counts_[channel], 8);
        }
    put_text(out, counts);
    return out;
}

void Writer::finish()
{
    close_chunk();
    std::string end;
    put_number(end, 0, 4); // no checksum of the whole: every chunk has its own
    put_record(out_, Opcode::data_end, end);

    const std::uint64_t summary_start = offset();
    std::string summary, offsets;
    const auto group = [&](Opcode opcode, auto&& put_all) {
        const std::size_t start = summary.size();
        put_all();
        if (summary.size() == start)
            return;
        std::string content;
        put_number(content, static_cast<std::uint8_t>(opcode), 1);
        put_number(content, summary_start + start, 8);
        put_number(content, summary.size() - start, 8);
        put_record(offsets, Opcode::summary_offset, content);
    };
    group(Opcode::schema, [&] {
        for (const auto& schema : schemas_)
            put_schema(summary, schema);
    });
    group(Opcode::channel, [&] {
        for (const auto& channel : channels_)
            put_channel(summary, channel);
    });
    group(Opcode::statistics, [&] { put_record(summary, Opcode::statistics, statistics()); });
    group(Opcode::chunk_index, [&] {
        for (const auto& chunk : chunks_) {
            std::string content, index;
            for (const std::uint64_t number : {chunk.start_ns, chunk.end_ns, chunk.offset, chunk.length})
                put_number(content, number, 8);
            for (const auto& [channel, place] : chunk.index_offsets) {
                put_number(index, channel, 2);
                put_number(index, place, 8);
            }
            put_text(content, index);
            put_number(content, chunk.index_length, 8);
            put_text(content, "");
            put_number(content, chunk.size, 8); // compressed
            put_number(content, chunk.size, 8);
            put_record(summary, Opcode::chunk_index, content);
        }
    });
    group(Opcode::attachment_index, [&] {
        for (const auto& place : attachments_)
            put_record(summary, Opcode::attachment_index, place.index);
    });
    group(Opcode::metadata_index, [&] {
        for (const auto& place : metadata_)
            put_record(summary, Opcode::metadata_index, place.index);
    });

    const std::uint64_t offsets_start = summary_start + summary.size();
    summary += offsets;
    put_record(summary, Opcode::footer, "");
    put_number(summary, summary_start, 8);
    put_number(summary, offsets_start, 8);
    constexpr std::uint64_t footer_size = 20;
    for (std::size_t i = 0; i < 8; ++i) // the length is part of what the checksum covers
        summary[summary.size() - 16 - 8 + i] = static_cast<char>(footer_size >> (8 * i) & 0xFF);
    put_number(summary, crc32(bytes_of(summary)), 4);
    out_ += summary;
    out_ += magic;
}

void Writer::written()
{
    gone_ += out_.size();
    out_.clear();
}

void Writer::drop_pending()
{
    out_.clear();
    const auto is_gone = [&](const auto& one) { return one.offset >= gone_; };
    for (const auto& chunk : chunks_)
        for (std::size_t i = 0; is_gone(chunk) && i < chunk.counts.size(); ++i) {
            counts_[chunk.index_offsets[i].first] -= chunk.counts[i];
            messages_ -= chunk.counts[i];
        }
    std::erase_if(chunks_, is_gone);
    std::erase_if(attachments_, is_gone);
    std::erase_if(metadata_, is_gone);
}

} // namespace sinew::record::mcap
