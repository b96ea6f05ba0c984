#include "sinew/family/sam/framing.hpp"

#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/select.hpp"

#include <array>

namespace sinew::sam {
namespace {

constexpr std::uint8_t header_byte = 0xFF;
constexpr std::uint8_t standard_mark = 0xE0;
constexpr int opcode_mode = 7; // of the modes in the upper bits of the byte after the header; the others have none
constexpr std::uint8_t first_standard_opcode = 0xA0; // quick opcodes end at 0x97 (S67)

/// What an opcode makes of a frame: its least size, and where the count of instructions stands, if it has one.
struct Shape {
    std::uint8_t size = 0; // 0: no such opcode
    std::uint8_t count_byte = 0;
    std::uint8_t unmasked_byte = 0;
};

consteval std::array<Shape, 256> make_shapes()
{
    std::array<Shape, 256> shapes{};
    for (const auto* message : manual_messages) {
        if (message->info.opcode < 0)
            continue;
        Shape& shape = shapes[static_cast<std::size_t>(message->info.opcode)];
        shape.size = message->request.size;
        for (const auto& f : message->request.fields) {
            if (f.kind == Kind::sequence)
                shape.count_byte = static_cast<std::uint8_t>(f.byte - 1);
            if (f.lenient != 0)
                shape.unmasked_byte = static_cast<std::uint8_t>(f.byte + f.lenient);
        }
    }
    return shapes;
}

constexpr std::array<Shape, 256> shapes = make_shapes();

/// The message of each opcode; nullptr: none.
consteval std::array<const MessageInfo*, 256> make_by_opcode()
{
    std::array<const MessageInfo*, 256> all{};
    for (const auto* message : manual_messages)
        if (message->info.opcode >= 0)
            all[static_cast<std::size_t>(message->info.opcode)] = message;
    return all;
}

constexpr std::array<const MessageInfo*, 256> by_opcode = make_by_opcode();

enum class Verdict : std::uint8_t { frame, not_yet, garbage };

struct Candidate {
    Verdict verdict = Verdict::not_yet;
    std::size_t size = 0;
};

constexpr Candidate garbage{Verdict::garbage};
constexpr Candidate not_yet{Verdict::not_yet};

Shape shape_of(std::uint8_t data1, std::uint8_t data2)
{
    const int mode = data1 >> 5;
    if (mode <= 5)
        return {.size = 4};
    if (mode == 6) {
        const int submode = data2 >> 4;
        return {.size = static_cast<std::uint8_t>(submode >= 1 && submode <= 4 ? 4 : 0)};
    }
    const bool is_standard = data2 >= first_standard_opcode;
    return is_standard && data1 != standard_mark ? Shape{} : shapes[data2];
}

/// Judges the bytes from a header on, as early as they allow it.
Candidate judge(std::span<const std::uint8_t> bytes)
{
    if (bytes.size() > 1 && bytes[1] == header_byte)
        return garbage;
    if (bytes.size() < 3)
        return not_yet;
    const Shape shape = shape_of(bytes[1], bytes[2]);
    if (shape.size == 0)
        return garbage;
    std::size_t size = shape.size;
    if (shape.count_byte != 0) {
        if (bytes.size() <= shape.count_byte)
            return not_yet;
        if (bytes[shape.count_byte] > 8)
            return garbage;
        size += 2U * bytes[shape.count_byte];
    }
    for (std::size_t i = 1; i < std::min(size, bytes.size()); ++i)
        if (bytes[i] == header_byte && i != shape.unmasked_byte)
            return garbage;
    if (bytes.size() < size)
        return not_yet;
    if (bytes[size - 1] != checksum(Checksum::xor7, bytes.data(), size))
        return garbage;
    return {Verdict::frame, size};
}

/// Quick control has no opcode: torque level and direction of rotation have the bits to themselves that tell the modes.
bool bits_fit(const Side& side, const Frame& frame)
{
    for (const auto& f : side.fields) {
        std::int64_t value = 0;
        if (f.kind == Kind::value && f.coding == Coding::bits && get(f, frame.data.data(), value) &&
            f.msb - f.lsb < 7 && !allowed(f).contains(value))
            return false;
    }
    return true;
}

/// The broadcast brake is answered with any id.
[[gnu::noinline]] bool is_same_device(const MessageInfo& message, const Frame& asked, const Frame& reply)
{
    std::int64_t from = 0;
    std::int64_t to = 0;
    get(*message.reply.device, reply.data.data(), from);
    get(*message.request.device, asked.data.data(), to);
    return from == to || (message.info.broadcast && to == message.request.device->range.high);
}

class SamProtocol final : public Protocol
{
public:
    Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const override
    {
        for (std::size_t at = 0; at < bytes.size(); ++at) {
            if (bytes[at] != header_byte)
                continue;
            const Candidate candidate = judge(bytes.subspan(at));
            if (candidate.verdict == Verdict::frame)
                return {at, candidate.size};
            if (candidate.verdict == Verdict::not_yet && !silent)
                return {at, 0};
        }
        return {bytes.size(), 0};
    }

    Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool) const override
    {
        return {0, awaited != 0 && bytes.size() >= awaited ? awaited : 0};
    }

    const MessageInfo* identify(const Frame& frame, Direction direction, const wire::Profile& profile) const override
    {
        if (direction == Direction::reply || frame.size < 4)
            return nullptr;
        if (frame.data[1] >> 5 == opcode_mode) {
            const MessageInfo* message = by_opcode[frame.data[2]];
            const bool exists = message != nullptr && profile.has(*message);
            return exists && selects(message->request, frame) ? message : nullptr;
        }
        for (const auto* message : profile.messages)
            if (message->info.opcode < 0 && selects(message->request, frame) && bits_fit(message->request, frame))
                return message;
        return nullptr;
    }

    int addressee(const Frame& request) const override
    {
        constexpr std::uint8_t id_bits = 0x1F;
        if (request.size < 4)
            return -1;
        if (request.data[1] == standard_mark && request.data[2] >= first_standard_opcode)
            return request.data[3];
        const int id = request.data[1] & id_bits;
        return quick.ids.contains(id) ? id : -1;
    }

    bool answers(const Frame& asked, const MessageInfo& message, const Frame& reply, Options) const override
    {
        if (reply.size != message.reply.size)
            return false;
        // Where an answer carries the id, it must be the right one.
        const Field* said = message.reply.device;
        const Field* meant = message.request.device;
        return said == nullptr || meant == nullptr || is_same_device(message, asked, reply);
    }

    bool is_answer(const Frame& asked, const MessageInfo& message, const Frame& reply, Options options) const override
    {
        return answers(asked, message, reply, options);
    }

    std::expected<Request, Error> probe(int id) const override { return make_request(id, Ping{}); }
    bool bare_replies() const override { return true; }
};

} // namespace

const Protocol& protocol()
{
    static const SamProtocol the_protocol;
    return the_protocol;
}

} // namespace sinew::sam
