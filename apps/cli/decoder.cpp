#include "apps/cli/decoder.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/wire/select.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using wire::Direction;
using wire::Frame;
using wire::MessageInfo;

constexpr Direction both[] = {Direction::request, Direction::reply};

/// Reads the frame as one message and adds the reading or the error.
void read_as(const Device& device, const MessageInfo& message, Direction direction, Decoded& out)
{
    const auto values = wire::decode(message, direction, out.frame, device.options());
    if (values)
        out.readings.push_back({direction, &message, values->id, show(device, message, values->values)});
    else if (!out.error)
        out.error = values.error();
}

/// Why bytes are no frame: the message that their selecting bytes name says what is wrong with the rest.
Error explain(const Device& device, std::span<const std::uint8_t> bytes)
{
    const Frame frame = to_frame(bytes);
    for (const auto* message : device.line().messages)
        for (const auto direction : both) {
            const auto& side = message->side(direction);
            // A bare reply is selected by any bytes of its size.
            if (!side.exists() || bytes.size() > Frame::capacity || !wire::selects(side, frame) ||
                (direction == Direction::reply && device.family->protocol->bare_replies()))
                continue;
            if (const auto decoded = wire::decode(*message, direction, frame, device.options()); !decoded)
                return decoded.error();
        }
    return {.code = Errc::bad_reply,
            .detail = fmt::format("{} {} no frame of {}", bytes.size(), bytes.size() == 1 ? "byte is" : "bytes are",
                                  device.family->name)};
}

std::vector<Decoded> read_stream(const Device& device, std::span<const std::uint8_t> bytes,
                                 const DecodeOptions& options)
{
    std::vector<Decoded> out;
    const auto garbage = [&](std::span<const std::uint8_t> part) {
        if (!part.empty())
            out.push_back(no_frame(device, part));
    };
    std::size_t skipped = 0;
    while (skipped < bytes.size()) {
        const auto scan = device.family->protocol->find_request(bytes.subspan(skipped), true);
        if (scan.size == 0)
            break;
        garbage(bytes.subspan(skipped, scan.skip));
        out.push_back(decode_frame(device, to_frame(bytes.subspan(skipped + scan.skip, scan.size)), options.only));
        skipped += scan.skip + scan.size;
    }
    garbage(bytes.subspan(skipped));
    return out;
}

std::expected<std::vector<Decoded>, Error> read_replies(const Device& device, const Captured& captured,
                                                        const DecodeOptions& options)
{
    const auto message = message_named(*device.family, device.line(), options.reply_to);
    if (!message)
        return std::unexpected(message.error());
    if (!(*message)->reply.exists())
        return fail(Errc::bad_argument, fmt::format("{} has no answer", (*message)->name()));
    std::vector<Decoded> out;
    const auto add = [&](const Frame& frame) { out.push_back(decode_reply(device, **message, frame)); };
    if (captured.is_can()) {
        add(captured.frame);
        return out;
    }
    // A row of answers is cut to size; what is left over is too short and says so.
    std::span<const std::uint8_t> bytes = captured.bytes;
    while (!bytes.empty()) {
        const auto part = bytes.first(std::min<std::size_t>(bytes.size(), (*message)->reply.size));
        add(to_frame(part));
        bytes = bytes.subspan(part.size());
    }
    return out;
}

} // namespace

std::expected<Device, Error> reader(const Family& family, const DecodeOptions& options)
{
    const auto line = profile_named(family, options.profile);
    if (!line)
        return std::unexpected(line.error());
    Device out{.family = &family, .asked_line = *line};
    if (options.model.empty() && family.name == "sam")
        return out;
    auto spec = make_spec(family, options.model, options.profile, family.default_id);
    if (!spec)
        return std::unexpected(spec.error());
    out.spec = std::move(*spec);
    return out;
}

Frame to_frame(std::span<const std::uint8_t> bytes)
{
    Frame frame{.size = static_cast<std::uint8_t>(std::min(bytes.size(), Frame::capacity))};
    std::ranges::copy(bytes.first(frame.size), frame.data.begin());
    return frame;
}

Decoded decode_frame(const Device& device, const Frame& frame, std::optional<Direction> only)
{
    Decoded out{.family = device.family, .frame = frame, .bytes = {frame.bytes().begin(), frame.bytes().end()}};
    for (const auto direction : both) {
        if (only && *only != direction)
            continue;
        if (const auto* message = device.family->protocol->identify(frame, direction, device.line()))
            read_as(device, *message, direction, out);
    }
    if (!out.readings.empty())
        out.error.reset();
    else if (!out.error)
        out.error = Error{
            .code = Errc::bad_reply,
            .detail = fmt::format("no message of {} ({}) looks like this", device.family->name, device.line().name)};
    return out;
}

Decoded decode_reply(const Device& device, const MessageInfo& message, const Frame& frame)
{
    Decoded out{.family = device.family, .frame = frame, .bytes = {frame.bytes().begin(), frame.bytes().end()}};
    read_as(device, message, Direction::reply, out);
    return out;
}

Decoded no_frame(const Device& device, std::span<const std::uint8_t> bytes)
{
    return {.family = device.family,
            .frame = to_frame(bytes),
            .bytes = {bytes.begin(), bytes.end()},
            .error = explain(device, bytes)};
}

const Family* guess_family(const Captured& captured)
{
    if (captured.is_can())
        return find_family("rmd");
    const auto& bytes = captured.bytes;
    constexpr std::uint8_t nuri_header[] = {0xFF, 0xFE};
    if (!std::ranges::search(bytes, nuri_header).empty())
        return find_family("nuri");
    return std::ranges::find(bytes, 0xFF) != bytes.end() ? find_family("sam") : nullptr;
}

std::expected<std::vector<Decoded>, Error> decode(const Captured& captured, const DecodeOptions& options)
{
    const Family* family = options.family != nullptr ? options.family : guess_family(captured);
    if (family == nullptr)
        return fail(Errc::bad_argument, "no header of a family in these bytes; say --family, and for answers of SAM "
                                        "--reply-to MESSAGE as well");
    const bool is_frame = captured.is_can();
    if (family->can != is_frame)
        return fail(Errc::bad_argument,
                    family->can ? fmt::format("{} is on CAN: write its frames with their identifier, such as "
                                              "141#9A00000000000000",
                                              family->name)
                                : fmt::format("{} is on a serial line and this is a CAN frame", family->name));
    const auto device = reader(*family, options);
    if (!device)
        return std::unexpected(device.error());
    if (!options.reply_to.empty())
        return read_replies(*device, captured, options);
    if (is_frame)
        return std::vector{decode_frame(*device, captured.frame, options.only)};
    return read_stream(*device, captured.bytes, options);
}

} // namespace sinew::cli
