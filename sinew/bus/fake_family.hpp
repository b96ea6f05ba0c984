#pragma once
#include "sinew/wire/protocol.hpp"
#include "sinew/wire/select.hpp"

/// A family for the tests of this room, so that they stand on no real one: `55 id opcode value`, on serial lines with
/// or without a frame around the reply, and on CAN as `100 + id`.
namespace sinew::bus::fake {

using namespace wire;

inline constexpr Field framed_fields[] = {constant("header", 0, 0x55),
                                          {.name = "id", .byte = 1, .kind = Kind::address, .range = {0, 9}},
                                          {.name = "opcode", .byte = 2, .kind = Kind::opcode}};
inline constexpr Layout framed{.name = "framed", .fields = framed_fields, .ids = {0, 9}};
inline constexpr Layout bare{.name = "bare"};
inline constexpr Field can_fields[] = {{.name = "opcode", .byte = 0, .kind = Kind::opcode}};
inline constexpr Layout can{.name = "can", .fields = can_fields, .can_base = 0x100, .ids = {0, 9}};

struct Number {
    std::uint8_t value{};
};

struct Read {
};
consteval auto row_of(const Read*)
{
    return message<Read, Number>({.name = "read", .opcode = 1}, side<Read>(framed, 4, reserved("free", 3)),
                                 side<Number>(framed, 4, u8(&Number::value, {.name = "value", .byte = 3})));
}

struct Set {
    std::uint8_t value{};
};
consteval auto row_of(const Set*)
{
    return message<Set, Number>({.name = "set", .opcode = 2, .access = Access::command},
                                side<Set>(framed, 4, u8(&Set::value, {.name = "value", .byte = 3})),
                                side<Number>(framed, 4, u8(&Number::value, {.name = "value", .byte = 3})));
}

struct BareRead {
};
consteval auto row_of(const BareRead*)
{
    return message<BareRead, Number>(
        {.name = "bare-read", .opcode = 3}, side<BareRead>(framed, 4, reserved("free", 3)),
        side<Number>(bare, 2, u8(&Number::value, {.name = "value", .byte = 0}), repeat("again", 1, 0)));
}

struct BareSet {
};
consteval auto row_of(const BareSet*)
{
    return message<BareSet, Number>(
        {.name = "bare-set", .opcode = 6, .access = Access::command}, side<BareSet>(framed, 4, reserved("free", 3)),
        side<Number>(bare, 2, u8(&Number::value, {.name = "value", .byte = 0}), repeat("again", 1, 0)));
}

struct Who {
    std::uint8_t id{};
};
struct BarePing {
};
consteval auto row_of(const BarePing*)
{
    return message<BarePing, Who>({.name = "bare-ping", .opcode = 4}, side<BarePing>(framed, 4, reserved("free", 3)),
                                  side<Who>(bare, 2, u8(&Who::id, {.name = "id", .byte = 0}), repeat("again", 1, 0)));
}

struct CanRead {
};
consteval auto row_of(const CanRead*)
{
    return message<CanRead, Number>({.name = "can-read", .opcode = 5}, side<CanRead>(can, 2, reserved("free", 1)),
                                    side<Number>(can, 2, u8(&Number::value, {.name = "value", .byte = 1})));
}

class FakeProtocol final : public Protocol
{
public:
    explicit FakeProtocol(bool bare_answers) : bare_(bare_answers) {}

    Scan find_request(std::span<const std::uint8_t> bytes, bool) const override { return {bytes.size(), 0}; }
    Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const override
    {
        if (bare_)
            return {0, awaited != 0 && bytes.size() >= awaited ? awaited : 0};
        for (std::size_t at = 0; at < bytes.size(); ++at)
            if (bytes[at] == 0x55 && (bytes.size() >= at + 4 || !silent))
                return {at, bytes.size() >= at + 4 ? 4U : 0U};
        return {bytes.size(), 0};
    }
    const MessageInfo* identify(const Frame&, Direction, const Profile&) const override { return nullptr; }
    int addressee(const Frame& request) const override { return request.data[1]; }
    bool answers(const Frame& asked, const MessageInfo& message, const Frame& reply, Options) const override
    {
        if (message.reply.layout == &bare)
            return reply.size == 2 && (&message != &info_of<BarePing> || reply.data[0] == asked.data[1]);
        if (message.reply.layout == &can)
            return (message.request.layout->can_fixed || reply.can_id == asked.can_id) && selects(message.reply, reply);
        return reply.data[1] == asked.data[1] && selects(message.reply, reply);
    }
    bool is_answer(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const override
    {
        return message.reply.layout == &can ? answers(asked, message, reply, options)
                                            : Protocol::is_answer(asked, message, reply, options);
    }
    std::expected<Request, Error> probe(int id) const override
    {
        return bare_ ? make_request(id, BarePing{}) : make_request(id, Read{});
    }
    bool bare_replies() const override { return bare_; }

private:
    bool bare_;
};

} // namespace sinew::bus::fake
