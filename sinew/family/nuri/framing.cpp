#include "sinew/family/nuri/framing.hpp"

#include "sinew/family/nuri/lines.hpp"
#include "sinew/wire/select.hpp"

namespace sinew::nuri {
namespace {

constexpr std::size_t before_payload = 6; // header, id, size, checksum, mode
constexpr std::size_t largest = 12;       // position and speed feedback

} // namespace

Scan Framing::find_request(std::span<const std::uint8_t> bytes, bool silent) const
{
    bool bad_checksum = false;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        const auto rest = bytes.subspan(at);
        if (rest[0] != 0xFF || (rest.size() > 1 && rest[1] != 0xFE))
            continue;
        if (rest.size() > 3 && (rest[3] < 2 || rest[3] + 4U > largest))
            continue;
        const std::size_t size = rest.size() > 3 ? rest[3] + 4U : before_payload;
        // The mode tells at the sixth byte whether the size can be right; modes that nobody documents have any.
        if (rest.size() >= before_payload && sizes_[rest[5]] != 0 && (sizes_[rest[5]] >> size & 1U) == 0)
            continue;
        if (rest.size() < size) {
            if (silent)
                continue;
            return {at, 0, bad_checksum};
        }
        if (rest[4] == checksum(Checksum::not_sum, rest.data(), size))
            return {at, size, bad_checksum};
        bad_checksum = true;
    }
    return {bytes.size(), 0, bad_checksum};
}

Scan Framing::find_reply(std::span<const std::uint8_t> bytes, std::size_t, bool silent) const
{
    return find_request(bytes, silent);
}

const MessageInfo* Framing::identify(const Frame& frame, wire::Direction direction, const wire::Profile& profile) const
{
    for (const auto* message : profile.messages) {
        // A reply has an entry of its own beside the request that asks for it.
        const bool own_entry = direction == wire::Direction::request || !message->request.exists();
        if (own_entry && message->side(direction).exists() && selects(message->side(direction), frame))
            return message;
    }
    return nullptr;
}

int Framing::addressee(const Frame& request) const
{
    constexpr int broadcast = 255;
    return request.size < before_payload || request.data[2] == broadcast ? -1 : request.data[2];
}

bool Framing::answers(const Frame& asked, const MessageInfo& message, const Frame& reply, Options) const
{
    return reply.data[2] == asked.data[2] && selects(message.reply, reply);
}

/// Header, size and mode are among what `answers` compares, and bytes that are 0 do not change the sum.
bool Framing::is_answer(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const
{
    return reply.data[4] == checksum(Checksum::not_sum, reply.data.data(), largest) &&
           answers(asked, message, reply, options);
}

std::expected<Request, Error> Framing::probe(int id) const
{
    return make_request(id, RequestPing{});
}

const Protocol& protocol()
{
    static const Framing the_protocol{{manual_messages, mc::messages}};
    return the_protocol;
}

} // namespace sinew::nuri
