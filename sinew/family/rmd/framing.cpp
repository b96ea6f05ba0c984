#include "sinew/family/rmd/framing.hpp"

#include "sinew/family/rmd/messages.hpp"
#include "sinew/wire/select.hpp"

namespace sinew::rmd {
namespace {

constexpr std::size_t parameter_byte = 1;

class RmdProtocol final : public Protocol
{
public:
    // CAN brings whole frames: there is nothing to find in bytes.
    Scan find_request(std::span<const std::uint8_t> bytes, bool) const override { return {bytes.size(), 0}; }
    Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t, bool) const override { return {bytes.size(), 0}; }

    const MessageInfo* identify(const Frame& frame, Direction direction, const wire::Profile& profile) const override
    {
        for (const auto* message : profile.messages) {
            const Side& side = message->side(direction);
            if (side.exists() && carries(side, frame, direction, profile.options) && selects(side, frame))
                return message;
        }
        return nullptr;
    }

    int addressee(const Frame& request) const override
    {
        const auto id = static_cast<int>(request.can_id - identifier_base);
        return command_frame.ids.contains(id) ? id : -1;
    }

    bool answers(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const override
    {
        const std::uint32_t base =
            options.can_reply_base != 0 ? options.can_reply_base : message.reply.layout->can_base;
        // Motors 1 to 4 answer the multi-motor frame, each with its own identifier (R25).
        if (message.request.layout->can_fixed)
            return reply.can_id > base && reply.can_id <= base + 4 && selects(message.reply, reply);
        const std::uint32_t id = asked.can_id - message.request.layout->can_base;
        const bool names_parameter = !message.request.selector.empty() || !message.reply.selector.empty();
        return reply.can_id == base + id &&
               (!names_parameter || reply.data[parameter_byte] == asked.data[parameter_byte]) &&
               selects(message.reply, reply);
    }
    bool is_answer(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const override
    {
        return answers(asked, message, reply, options);
    }

    std::expected<Request, Error> probe(int id) const override { return make_request(id, ReadStatus1{}); }

private:
    static bool carries(const Side& side, const Frame& frame, Direction direction, Options options)
    {
        if (side.layout->can_fixed)
            return frame.can_id == side.layout->can_base;
        const bool other = direction == Direction::reply && options.can_reply_base != 0;
        const std::uint32_t base = other ? options.can_reply_base : side.layout->can_base;
        return frame.can_id >= base && side.layout->ids.contains(frame.can_id - base);
    }
};

} // namespace

const Protocol& protocol()
{
    static const RmdProtocol the_protocol;
    return the_protocol;
}

} // namespace sinew::rmd
