#include "sinew/record/recovery.hpp"

namespace sinew::record {
namespace {

// A file full of errors is not worth more than this many of them.
constexpr std::size_t most_problems = 1000;

} // namespace

void Recovery::feed(std::span<const std::uint8_t> bytes)
{
    reader_.feed(bytes);
    drain();
}

std::expected<void, Error> Recovery::end()
{
    reader_.end();
    drain();
    if (!is_mcap_)
        return std::unexpected(problems_.front());
    writer_.finish();
    return {};
}

void Recovery::take(const mcap::Message& message)
{
    const auto [place, is_new] = channels_.try_emplace(message.channel);
    if (is_new) {
        mcap::Channel channel = *message.channel;
        const auto* schema = reader_.schema(channel.schema_id);
        channel.schema_id = 0;
        if (schema != nullptr) {
            const auto [known, is_new_schema] = schemas_.try_emplace(schema);
            if (is_new_schema)
                known->second = writer_.add_schema(*schema);
            channel.schema_id = known->second;
        }
        place->second = writer_.add_channel(std::move(channel));
    }
    writer_.add(place->second, message.stamp, message.data);
    ++count_.messages;
}

void Recovery::drain()
{
    for (;;) {
        const auto item = reader_.next();
        if (!item) {
            is_mcap_ = is_mcap_ && reader_.is_mcap();
            if (problems_.size() < most_problems)
                problems_.push_back(item.error());
        } else if (!*item) {
            return;
        } else if (const auto* message = std::get_if<mcap::Message>(&**item)) {
            take(*message);
        } else if (const auto* attachment = std::get_if<mcap::Attachment>(&**item)) {
            writer_.attach(*attachment);
            ++count_.attachments;
        } else {
            writer_.add(std::get<mcap::Metadata>(**item));
            ++count_.metadata;
        }
    }
}

} // namespace sinew::record
