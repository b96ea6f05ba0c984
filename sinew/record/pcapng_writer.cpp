#include "sinew/record/little_endian.hpp"
#include "sinew/record/pcapng.hpp"
#include "sinew/record/pcapng_format.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

namespace sinew::record {
namespace {

using namespace pcapng;

// Written in the order of the machines that are in use.

void put_option(std::string& out, std::uint16_t code, std::string_view value)
{
    value = value.substr(0, std::numeric_limits<std::uint16_t>::max());
    put_number(out, code, 2);
    put_number(out, value.size(), 2);
    out += value;
    out.append(padded(value.size()) - value.size(), '\0');
}

void put_block(std::string& out, std::uint32_t type, std::string_view body)
{
    put_number(out, type, 4);
    put_number(out, body.size() + block_frame, 4);
    out += body;
    put_number(out, body.size() + block_frame, 4);
}

std::string section()
{
    std::string body;
    put_number(body, byte_order_magic, 4);
    put_number(body, 1, 2); // version 1.0
    put_number(body, 0, 2);
    put_number(body, ~0ULL, 8); // length not known
    put_option(body, user_application, "sinew");
    put_option(body, end_of_options, "");
    return body;
}

std::string can_packet(const Captured& captured)
{
    std::uint32_t id = captured.frame.can_id & identifier_bits;
    if (captured.extended)
        id |= extended_flag;
    if (captured.kind == Captured::Kind::can_remote)
        id |= remote_flag;
    if (captured.kind == Captured::Kind::can_error)
        id |= error_flag;
    std::string out;
    for (const int shift : {24, 16, 8, 0}) // big-endian in every file
        out += static_cast<char>(id >> shift & 0xFF);
    put_number(out, captured.frame.size, 1);
    put_number(out, 0, 3);
    const auto data = captured.data();
    return out.append(reinterpret_cast<const char*>(data.data()), data.size());
}

} // namespace

std::expected<void, Error> PcapngWriter::add(const Captured& captured, std::string& out)
{
    const auto since = captured.at.time_since_epoch().count();
    if (since < 0)
        return fail(Errc::bad_argument, "a pcapng file of sinew holds no time before 1970");
    constexpr std::size_t most = PcapngReader::longest_block / 2;
    if (captured.data().size() + captured.bus.size() + captured.family.size() + captured.discarded.size() > most)
        return fail(Errc::bad_argument, fmt::format("{} bytes are too many for one packet", captured.data().size()));
    if (!begun_)
        put_block(out, section_block, section());
    begun_ = true;
    const Known bus{captured.bus, captured.family, captured.is_can()};
    auto known = std::ranges::find(interfaces_, bus);
    if (known == interfaces_.end()) {
        std::string body;
        put_number(body, bus.can ? can_socketcan : user0, 2);
        put_number(body, 0, 2);
        put_number(body, 0, 4); // packets are kept whole
        if (!bus.bus.empty())
            put_option(body, interface_name, bus.bus);
        if (!bus.family.empty())
            put_option(body, description, bus.family);
        put_option(body, time_resolution, std::string(1, static_cast<char>(nanoseconds)));
        put_option(body, end_of_options, "");
        put_block(out, interface_block, body);
        known = interfaces_.insert(interfaces_.end(), bus);
    }
    const std::string packet =
        bus.can ? can_packet(captured)
                : std::string(reinterpret_cast<const char*>(captured.bytes.data()), captured.bytes.size());
    std::string body;
    put_number(body, static_cast<std::uint64_t>(known - interfaces_.begin()), 4);
    put_number(body, static_cast<std::uint64_t>(since) >> 32, 4);
    put_number(body, static_cast<std::uint64_t>(since) & 0xFFFF'FFFF, 4);
    put_number(body, packet.size(), 4);
    put_number(body, packet.size(), 4);
    body += packet;
    body.append(padded(packet.size()) - packet.size(), '\0');
    if (captured.direction) {
        std::string flags;
        put_number(flags, *captured.direction == wire::Direction::request ? outbound : inbound, 4);
        put_option(body, packet_flags, flags);
    }
    if (!captured.discarded.empty())
        put_option(body, comment, captured.discarded);
    if (captured.direction || !captured.discarded.empty())
        put_option(body, end_of_options, "");
    put_block(out, packet_block, body);
    return {};
}

} // namespace sinew::record
