#include "sinew/record/mcap_frames.hpp"

#include <algorithm>

namespace sinew::record {

std::expected<std::optional<Captured>, Error> McapFrameReader::next()
{
    for (;;) {
        const auto item = reader_.next();
        if (!item)
            return std::unexpected(item.error());
        if (!*item)
            return std::nullopt;
        const auto* message = std::get_if<mcap::Message>(&**item);
        if (message == nullptr || topic_of(reader_, *message->channel) != Topic::frame)
            continue;
        auto frame = frame_from(*message);
        if (!frame)
            return std::unexpected(frame.error());
        return *std::move(frame);
    }
}

void McapFrameWriter::take(std::string& out)
{
    out += writer_.pending();
    writer_.written();
}

std::expected<void, Error> McapFrameWriter::add(const Captured& captured, std::string& out)
{
    const auto since = captured.at.time_since_epoch().count();
    if (since < 0)
        return fail(Errc::bad_argument, "a recording of sinew holds no time before 1970");
    auto known = std::ranges::find_if(known_, [&](const Known& one) {
        return one.bus == captured.bus && one.family == captured.family && one.can == captured.is_can();
    });
    if (known == known_.end()) {
        if (schema_ == 0)
            schema_ = writer_.add_schema(schema_of(Topic::frame));
        auto channel = channel_of({.name = captured.bus, .family = captured.family, .can = captured.is_can()});
        channel.schema_id = schema_;
        known = known_.insert(known_.end(), {captured.bus, captured.family, captured.is_can(),
                                             writer_.add_channel(std::move(channel)), 0});
    }
    const auto at = static_cast<std::uint64_t>(since);
    writer_.add(known->channel, {.sequence = known->sequence++, .log_time_ns = at, .publish_time_ns = at},
                [&](std::string& text) { put_frame(text, captured); });
    take(out);
    return {};
}

void McapFrameWriter::flush(std::string& out)
{
    writer_.close_chunk();
    take(out);
}

void McapFrameWriter::finish(std::string& out)
{
    writer_.finish();
    take(out);
}

} // namespace sinew::record
