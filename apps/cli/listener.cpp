#include "apps/cli/listener.hpp"

#include "sinew/link/can_error.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

namespace sinew::cli {
namespace {

using record::Captured;
using wire::Direction;

void drop(std::vector<std::uint8_t>& bytes, std::size_t count)
{
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min(count, bytes.size())));
}

void keep_reading(Decoded& decoded, Direction direction)
{
    std::erase_if(decoded.readings, [&](const Reading& r) { return r.direction != direction; });
}

} // namespace

std::expected<Listener, Error> Listener::make(DecodeOptions options, std::vector<Device> devices)
{
    Listener out(std::move(options));
    out.devices_ = std::move(devices);
    for (const auto* family : families()) {
        auto device = reader(*family, out.options_);
        // A model or profile that was named belongs to one family; the others are read by their manuals.
        if (!device && family == out.options_.family)
            return std::unexpected(device.error());
        if (!device)
            device = reader(*family, {});
        if (device)
            out.readers_.emplace(family, std::move(*device));
    }
    return out;
}

const Device& Listener::device(const Family& family, int id) const
{
    for (const auto& one : devices_)
        if (one.family == &family && one.id == id)
            return one;
    return readers_.at(&family);
}

void Listener::hear(const Captured& captured, const Use& use)
{
    Line& line = lines_[captured.bus];
    if (captured.at - line.last > silence)
        flush(captured.bus, line, use);
    line.last = captured.at;
    if (line.family == nullptr)
        line.family = options_.family != nullptr ? options_.family : find_family(captured.family);
    // Bytes of a family that cannot be told yet are shown as they are, until one comes that tells.
    if (line.family == nullptr || line.family->can != captured.is_can())
        line.family = guess_family(captured);
    Heard heard{.at = captured.at,
                .bus = captured.bus,
                .kind = captured.kind,
                .side = captured.direction ? Heard::Side::capture : Heard::Side::unknown,
                .direction = captured.direction,
                .discarded = captured.discarded};
    if (captured.is_can())
        hear_can(line, captured, heard, use);
    else
        hear_bytes(line, captured, heard, use);
}

void Listener::hear_can(Line& line, const Captured& captured, Heard& heard, const Use& use)
{
    const auto refuse = [&](std::string why) {
        const auto data = captured.data();
        heard.decoded = {.family = line.family,
                         .frame = captured.frame,
                         .bytes = {data.begin(), data.end()},
                         .error = Error{.code = Errc::bad_reply, .detail = std::move(why)}};
        use(heard);
    };
    if (captured.kind == Captured::Kind::can_error)
        return refuse(link::can_error_sentence(captured.frame));
    if (captured.kind == Captured::Kind::can_remote)
        return refuse("a remote request; no family uses those");
    if (captured.extended)
        return refuse("an identifier of 29 bits; no family uses those");
    const Family& family = *line.family;
    heard.decoded = decode_frame(readers_.at(&family), captured.frame, heard.direction);
    auto& readings = heard.decoded.readings;
    if (!readings.empty())
        if (const auto& known = device(family, readings.front().id); known.spec)
            heard.decoded = decode_frame(known, captured.frame, heard.direction);
    const std::pair key{captured.frame.can_id, captured.frame.data[0]};
    const auto asked = line.on_can.find(key);
    if (readings.size() > 1) {
        const bool answers = asked != line.on_can.end() && captured.at - asked->second <= answer_most;
        heard.side = Heard::Side::order;
        keep_reading(heard.decoded, answers ? Direction::reply : Direction::request);
    } else if (heard.side == Heard::Side::unknown && !readings.empty()) {
        heard.side = Heard::Side::frame;
    }
    if (!readings.empty())
        heard.direction = readings.front().direction;
    if (heard.direction == Direction::request)
        line.on_can[key] = captured.at;
    else if (asked != line.on_can.end())
        line.on_can.erase(asked);
    use(heard);
}

void Listener::hear_bytes(Line& line, const Captured& captured, Heard& heard, const Use& use)
{
    if (line.family == nullptr) {
        heard.decoded = {.frame = to_frame(captured.bytes), .bytes = captured.bytes};
        heard.decoded.error = Error{.code = Errc::bad_reply, .detail = "no family is known here; --family says it"};
        use(heard);
        return;
    }
    if (captured.direction == Direction::reply) {
        line.from_devices.insert(line.from_devices.end(), captured.bytes.begin(), captured.bytes.end());
        take_replies(line, false, heard, use);
    } else {
        line.from_host.insert(line.from_host.end(), captured.bytes.begin(), captured.bytes.end());
        take_requests(line, line.from_host, !captured.direction, false, heard, use);
    }
}

/// A whole frame that was cut out by its framing.
void Listener::frame(Line& line, std::span<const std::uint8_t> bytes, Heard& heard, const Use& use)
{
    const Family& family = *line.family;
    const auto known_side = heard.direction;
    heard.decoded = decode_frame(readers_.at(&family), to_frame(bytes), known_side);
    auto& readings = heard.decoded.readings;
    if (!readings.empty())
        if (const auto& known = device(family, readings.front().id); known.spec)
            heard.decoded = decode_frame(known, to_frame(bytes), known_side);
    if (readings.size() > 1)
        keep_reading(heard.decoded, Direction::request);
    if (!known_side && !readings.empty()) {
        heard.side = Heard::Side::frame;
        heard.direction = readings.front().direction;
    }
    if (family.protocol->bare_replies()) {
        line.asked = {};
        if (!readings.empty() && readings.front().message->reply.exists())
            line.asked = {readings.front().message, readings.front().id};
    }
    use(heard);
    heard.direction = known_side;
    if (!known_side)
        heard.side = Heard::Side::unknown;
}

void Listener::garbage(const Line& line, std::span<const std::uint8_t> bytes, Heard& heard, const Use& use)
{
    if (bytes.empty())
        return;
    heard.decoded = no_frame(readers_.at(line.family), bytes);
    use(heard);
}

/// True when it took one and there may be more.
bool Listener::take_bare_reply(Line& line, std::vector<std::uint8_t>& bytes, bool mixed, bool silent, Heard& heard,
                               const Use& use)
{
    if (line.asked.message == nullptr || bytes.empty())
        return false;
    const std::size_t size = line.asked.message->reply.size;
    if (mixed) {
        // Whoever was asked may have stayed silent, and this is the next request.
        const auto scan = line.family->protocol->find_request(bytes, silent);
        if (scan.skip == 0)
            return false;
    }
    if (bytes.size() < size)
        return false;
    const auto known_side = heard.direction;
    heard.decoded =
        decode_reply(device(*line.family, line.asked.id), *line.asked.message, to_frame(std::span(bytes).first(size)));
    for (auto& reading : heard.decoded.readings)
        reading.id = line.asked.id;
    heard.direction = Direction::reply;
    if (!known_side)
        heard.side = Heard::Side::order;
    line.asked = {};
    drop(bytes, size);
    use(heard);
    heard.direction = known_side;
    if (!known_side)
        heard.side = Heard::Side::unknown;
    return true;
}

void Listener::take_requests(Line& line, std::vector<std::uint8_t>& bytes, bool mixed, bool silent, Heard& heard,
                             const Use& use)
{
    while (!bytes.empty()) {
        if (mixed && take_bare_reply(line, bytes, true, silent, heard, use))
            continue;
        const bool reply_due = mixed && line.asked.message != nullptr;
        const auto scan = line.family->protocol->find_request(bytes, silent);
        // The first bytes of an answer are no garbage yet.
        if (reply_due && !silent && scan.skip != 0 && bytes.size() < line.asked.message->reply.size)
            return;
        garbage(line, std::span(bytes).first(scan.skip), heard, use);
        if (scan.size != 0) {
            const std::vector<std::uint8_t> one(bytes.begin() + static_cast<std::ptrdiff_t>(scan.skip),
                                                bytes.begin() + static_cast<std::ptrdiff_t>(scan.skip + scan.size));
            drop(bytes, scan.skip + scan.size);
            frame(line, one, heard, use);
            continue;
        }
        drop(bytes, scan.skip);
        if (silent) {
            garbage(line, bytes, heard, use);
            bytes.clear();
        }
        return;
    }
}

void Listener::take_replies(Line& line, bool silent, Heard& heard, const Use& use)
{
    auto& bytes = line.from_devices;
    if (!line.family->protocol->bare_replies()) {
        take_requests(line, bytes, false, silent, heard, use);
        return;
    }
    while (take_bare_reply(line, bytes, false, silent, heard, use))
        ;
    if (line.asked.message == nullptr || silent) {
        garbage(line, bytes, heard, use);
        bytes.clear();
    }
}

void Listener::flush(const std::string& bus, Line& line, const Use& use)
{
    if (line.family == nullptr)
        return;
    Heard heard{.at = line.last, .bus = bus};
    take_requests(line, line.from_host, true, true, heard, use);
    heard.direction = Direction::reply;
    heard.side = Heard::Side::capture;
    take_replies(line, true, heard, use);
    line.asked = {};
}

void Listener::fall_silent(const Use& use)
{
    for (auto& [bus, line] : lines_)
        flush(bus, line, use);
}

} // namespace sinew::cli
