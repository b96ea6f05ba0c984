#include "sinew/diagnosis/probes.hpp"

#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>

namespace sinew::diagnosis {
namespace {

/// Bytes for where a device looks at none. Which of them are harmless depends on everything around them; alternating
/// bits differ most from each other at another rate.
constexpr std::uint8_t fillings[] = {0x00, 0x55, 0x2A, 0x7F, 0x33, 0x66, 0x0F, 0x70, 0x5A, 0x6D, 0x1B};

/// The request with other bytes in its first two reserved places, and the checksum that fits.
wire::Request filled(wire::Request request, std::uint8_t first, std::uint8_t second)
{
    const auto& side = request.message->request;
    auto& data = request.frame.data;
    const std::uint8_t bytes[] = {first, second};
    std::size_t used = 0;
    for (const auto& field : side.fields)
        if (field.kind == wire::Kind::reserved && field.msb == 7 && field.lsb == 0 && used < std::size(bytes))
            data[field.byte] = bytes[used++];
    if (const int at = wire::checksum_byte(*side.layout, request.frame.size); at >= 0)
        data[static_cast<std::size_t>(at)] = wire::checksum(side.layout->checksum, data.data(), request.frame.size);
    return request;
}

/// Bytes before a frame that shift what others hear; a device passes over what is no header.
constexpr std::uint8_t prefixes[] = {0x00, 0x55, 0x0F, 0x70, 0x33, 0x2A, 0x7C, 0x1E, 0x5A, 0x3F, 0x01};

/// The request after one more byte. Only for requests whose answer is not told by a byte of theirs.
wire::Request after(std::uint8_t prefix, wire::Request request)
{
    auto& frame = request.frame;
    std::copy_backward(frame.data.begin(), frame.data.begin() + frame.size, frame.data.begin() + frame.size + 1);
    frame.data[0] = prefix;
    ++frame.size;
    return request;
}

void add_filled(std::vector<wire::Request>& out, const wire::Request& plain)
{
    for (const auto first : fillings)
        for (const auto second : fillings)
            if (first != 0 || second != 0)
                out.push_back(filled(plain, first, second));
}

void add_prefixed(std::vector<wire::Request>& out)
{
    for (std::size_t i = 0, plain = out.size(); i < plain; ++i)
        for (const auto prefix : prefixes)
            out.push_back(after(prefix, out[i]));
}

template <class M>
void add(std::vector<wire::Request>& out, int id, bool with_fillings)
{
    const auto plain = wire::make_request(id, M{});
    if (!plain)
        return;
    out.push_back(*plain);
    if (with_fillings)
        add_filled(out, *plain);
}

void set_response_time(std::vector<wire::Request>& requests, const Family& family)
{
    for (auto& request : requests)
        request.response_time = family.response_time.typical;
}

} // namespace

std::span<const std::uint8_t> fillers()
{
    return prefixes;
}

std::vector<wire::Request> ways_to_ask(const Family& family, int id)
{
    std::vector<wire::Request> out;
    if (family.name == "sam") {
        add<sam::Ping>(out, id, true);
        add<sam::ReadFirmwareVersion>(out, id, true);
        add<sam::QuickReadStatus>(out, id, true);
        add<sam::ReadTemperatureError>(out, id, true);
        add<sam::ReadDriveMode>(out, id, true);
        add<sam::ReadInputVoltage>(out, id, true);
        add<sam::ReadPdGain>(out, id, true);
    } else if (family.name == "nuri") {
        add<nuri::RequestPing>(out, id, false);
        add<nuri::RequestPositionFeedback>(out, id, false);
        add<nuri::RequestSpeedFeedback>(out, id, false);
        add<nuri::RequestPositionControllerFeedback>(out, id, false);
        add<nuri::RequestSpeedControllerFeedback>(out, id, false);
        add<nuri::RequestResponseTimeFeedback>(out, id, false);
    } else if (const auto probe = family.protocol->probe(id)) {
        out.push_back(*probe);
    }
    set_response_time(out, family);
    return out;
}

std::vector<wire::Request> ways_to_ask_model(const Family& family, int id)
{
    std::vector<wire::Request> out;
    if (family.name == "sam")
        add<sam::ReadFirmwareVersion>(out, id, true);
    add_prefixed(out);
    set_response_time(out, family);
    return out;
}

std::vector<wire::Request> ways_to_send(const Family& family, const wire::Request& read)
{
    std::vector<wire::Request> out{read};
    if (family.name != "sam")
        return out;
    add_filled(out, read);
    if (read.message->name() != "ping")
        add_prefixed(out);
    return out;
}

std::optional<wire::Request> safe_one(std::span<const wire::Request> ways, const Audience& audience,
                                      std::uint32_t bit_rate)
{
    for (const auto& way : ways)
        if (audience.harmless(way.frame, bit_rate))
            return way;
    return std::nullopt;
}

} // namespace sinew::diagnosis
