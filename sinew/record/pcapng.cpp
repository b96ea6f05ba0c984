#include "sinew/record/pcapng.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <utility>

namespace sinew::record {
namespace {

constexpr std::uint32_t section_block = 0x0A0D'0D0A, interface_block = 1, simple_packet = 3, packet_block = 6;
constexpr std::uint32_t byte_order_magic = 0x1A2B'3C4D;
constexpr std::uint16_t end_of_options = 0, comment = 1;
constexpr std::uint16_t user_application = 4;                                                       // of a section
constexpr std::uint16_t interface_name = 2, description = 3, time_resolution = 9, time_offset = 14; // of an interface
constexpr std::uint16_t packet_flags = 2;                                                           // of a packet
constexpr std::uint32_t direction_bits = 3, inbound = 1, outbound = 2;
constexpr std::uint16_t can_socketcan = 227, user0 = 147;
constexpr std::uint8_t nanoseconds = 9;

constexpr std::uint32_t extended_flag = 0x8000'0000, remote_flag = 0x4000'0000, error_flag = 0x2000'0000;
constexpr std::uint32_t identifier_bits = 0x1FFF'FFFF, standard_bits = 0x7FF;
constexpr std::uint8_t fd_frame_flag = 0x04;
constexpr std::size_t can_header = 8, most_data = 8;
constexpr std::size_t block_frame = 12; // type, length, and the length again

constexpr std::size_t padded(std::size_t size)
{
    return (size + 3) / 4 * 4;
}

// Written in the order of the machines that are in use.
void put(std::string& out, std::uint64_t value, std::size_t size)
{
    for (std::size_t i = 0; i < size; ++i)
        out += static_cast<char>(value >> (8 * i) & 0xFF);
}

void put_option(std::string& out, std::uint16_t code, std::string_view value)
{
    value = value.substr(0, std::numeric_limits<std::uint16_t>::max());
    put(out, code, 2);
    put(out, value.size(), 2);
    out += value;
    out.append(padded(value.size()) - value.size(), '\0');
}

void put_block(std::string& out, std::uint32_t type, std::string_view body)
{
    put(out, type, 4);
    put(out, body.size() + block_frame, 4);
    out += body;
    put(out, body.size() + block_frame, 4);
}

std::string section()
{
    std::string body;
    put(body, byte_order_magic, 4);
    put(body, 1, 2); // version 1.0
    put(body, 0, 2);
    put(body, ~0ULL, 8); // length not known
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
    put(out, captured.frame.size, 1);
    put(out, 0, 3);
    const auto data = captured.data();
    return out.append(reinterpret_cast<const char*>(data.data()), data.size());
}

std::expected<void, std::string> read_can(std::span<const std::uint8_t> packet, Captured& out)
{
    if (packet.size() < can_header)
        return std::unexpected(fmt::format("a CAN packet of {} bytes; its header alone has 8", packet.size()));
    std::uint32_t id = 0;
    for (const std::uint8_t byte : packet.first(4))
        id = id << 8 | byte;
    const std::uint8_t size = packet[4];
    if ((packet[5] & fd_frame_flag) != 0 || size > most_data)
        return std::unexpected("a CAN FD frame; no family uses those");
    out.kind = (id & error_flag) != 0    ? Captured::Kind::can_error
               : (id & remote_flag) != 0 ? Captured::Kind::can_remote
                                         : Captured::Kind::can;
    out.extended = (id & extended_flag) != 0;
    out.frame.can_id = id & identifier_bits;
    if (out.kind != Captured::Kind::can_error && !out.extended && out.frame.can_id > standard_bits)
        return std::unexpected(
            fmt::format("the identifier {:X} has more than 11 bits and is not marked so", out.frame.can_id));
    out.frame.size = size;
    if (out.kind == Captured::Kind::can_remote)
        return {};
    if (packet.size() - can_header < size)
        return std::unexpected(fmt::format("a CAN packet says {} bytes and has {}", size, packet.size() - can_header));
    std::ranges::copy(packet.subspan(can_header, size), out.frame.data.begin());
    return {};
}

std::string text_of(std::span<const std::uint8_t> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace

void PcapngReader::feed(Bytes bytes)
{
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::exchange(at_, 0)));
    if (!broken_)
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::uint32_t PcapngReader::number(Bytes bytes, std::size_t at, std::size_t size) const
{
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
        value = value << 8 | bytes[at + (big_endian_ ? i : size - 1 - i)];
    return value;
}

/// The body of the next block, empty with type 0 where more is needed; an error breaks the chain.
std::expected<PcapngReader::Bytes, std::string> PcapngReader::next_block(std::uint32_t& type)
{
    type = 0;
    const Bytes rest = std::span(bytes_).subspan(at_);
    const auto cut = [&]() -> std::expected<Bytes, std::string> {
        if (ended_ && !rest.empty())
            return std::unexpected("the file ends inside this block; all before it was read");
        return Bytes{};
    };
    if (rest.size() < block_frame)
        return cut();
    const bool begins_section = number(rest, 0, 4) == section_block; // the same in both byte orders
    if (begins_section) {
        big_endian_ = true;
        const std::uint32_t magic = number(rest, 8, 4);
        big_endian_ = magic == byte_order_magic;
        if (!big_endian_ && number(rest, 8, 4) != byte_order_magic)
            return std::unexpected("a section without its byte-order mark");
    } else if (!in_section_) {
        return std::unexpected("this is no pcapng file: it does not begin with a section header");
    }
    const std::uint32_t size = number(rest, 4, 4);
    if (size < block_frame || size % 4 != 0 || size > longest_block)
        return std::unexpected(fmt::format("a block cannot be {} bytes long", size));
    if (rest.size() < size)
        return cut();
    if (number(rest, size - 4, 4) != size)
        return std::unexpected(
            fmt::format("a block of {} bytes that says {} at its end", size, number(rest, size - 4, 4)));
    type = number(rest, 0, 4);
    return rest.subspan(8, size - block_frame);
}

template <class F>
std::expected<void, std::string> PcapngReader::for_each_option(Bytes options, F&& use) const
{
    while (options.size() >= 4) {
        const auto code = static_cast<std::uint16_t>(number(options, 0, 2));
        const std::size_t size = number(options, 2, 2);
        if (code == end_of_options)
            return {};
        if (options.size() < 4 + padded(size))
            return std::unexpected(fmt::format("option {} is longer than its block", code));
        if (auto used = use(code, options.subspan(4, size)); !used)
            return used;
        options = options.subspan(4 + padded(size));
    }
    return {};
}

std::expected<void, std::string> PcapngReader::read_section(Bytes body)
{
    constexpr std::size_t fixed = 16;
    interfaces_.clear();
    in_section_ = true;
    if (body.size() < fixed)
        return std::unexpected("a section header that is too short");
    if (number(body, 4, 2) != 1)
        return std::unexpected(fmt::format("version {} of pcapng; version 1 is known", number(body, 4, 2)));
    return {};
}

std::expected<void, std::string> PcapngReader::read_interface(Bytes body)
{
    constexpr std::size_t fixed = 8;
    Interface out;
    // It counts even where it cannot be read: packets refer to it by its number.
    interfaces_.emplace_back();
    if (body.size() < fixed)
        return std::unexpected("an interface description that is too short");
    out.link_type = static_cast<std::uint16_t>(number(body, 0, 2));
    const auto read =
        for_each_option(body.subspan(fixed), [&](std::uint16_t code, Bytes value) -> std::expected<void, std::string> {
            constexpr std::uint8_t base_two = 0x80, most_ten = 19, most_two = 63;
            if (code == interface_name)
                out.name = text_of(value);
            if (code == description)
                out.family = text_of(value);
            if (code == time_resolution && !value.empty()) {
                out.resolution = value[0];
                const bool is_two = (value[0] & base_two) != 0;
                if ((value[0] & ~base_two) > (is_two ? most_two : most_ten))
                    return std::unexpected(fmt::format("a resolution of time of {:#x}", value[0]));
            }
            if (code == time_offset && value.size() == 8) {
                const std::uint64_t high = number(value, big_endian_ ? 0 : 4, 4);
                out.offset_s = static_cast<std::int64_t>(high << 32 | number(value, big_endian_ ? 4 : 0, 4));
            }
            return {};
        });
    if (read)
        interfaces_.back() = std::move(out);
    return read;
}

std::expected<Time, std::string> PcapngReader::time_of(const Interface& interface, std::uint64_t ticks) const
{
    constexpr std::uint8_t base_two = 0x80;
    constexpr std::uint64_t per_second = 1'000'000'000;
    constexpr std::int64_t last_second = 9'000'000'000; // of what fits into 64 bits of nanoseconds
    const std::uint8_t power = interface.resolution & ~base_two;
    std::uint64_t ticks_per_second = 1;
    for (std::uint8_t i = 0; i < power; ++i)
        ticks_per_second *= (interface.resolution & base_two) != 0 ? 2 : 10;
    const std::uint64_t second = ticks / ticks_per_second;
    const std::uint64_t rest = ticks % ticks_per_second;
    const bool exact = ticks_per_second <= std::numeric_limits<std::uint64_t>::max() / per_second;
    const auto part = exact ? rest * per_second / ticks_per_second
                            : static_cast<std::uint64_t>(static_cast<long double>(rest) * per_second /
                                                         static_cast<long double>(ticks_per_second));
    if (second > last_second || interface.offset_s > last_second || interface.offset_s < -last_second)
        return std::unexpected("a time beyond the year 2255");
    const std::int64_t total = static_cast<std::int64_t>(second) + interface.offset_s;
    if (total > last_second || total < -last_second)
        return std::unexpected("a time beyond the year 2255");
    return Time{std::chrono::seconds(total) + Duration{static_cast<std::int64_t>(std::min(part, per_second - 1))}};
}

std::expected<Captured, std::string> PcapngReader::read_packet(Bytes body) const
{
    constexpr std::size_t fixed = 20;
    if (body.size() < fixed)
        return std::unexpected("a packet block that is too short");
    const std::uint32_t index = number(body, 0, 4);
    const std::size_t size = number(body, 12, 4);
    if (index >= interfaces_.size())
        return std::unexpected(fmt::format("a packet of interface {}, of which there is no description", index));
    if (size > body.size() - fixed || padded(size) > body.size() - fixed)
        return std::unexpected(fmt::format("a packet of {} bytes in a block that has {}", size, body.size() - fixed));
    if (number(body, 16, 4) != size)
        return std::unexpected(fmt::format("a packet of {} bytes of which {} were kept", number(body, 16, 4), size));
    if (!interfaces_[index])
        return std::unexpected(fmt::format("a packet of interface {}, whose description could not be read", index));
    const Interface& interface = *interfaces_[index];
    const std::uint64_t high = number(body, 4, 4);
    const auto at = time_of(interface, high << 32 | number(body, 8, 4));
    if (!at)
        return std::unexpected(at.error());
    Captured out{.at = *at, .bus = interface.name, .family = interface.family};
    const Bytes packet = body.subspan(fixed, size);
    if (interface.link_type == can_socketcan) {
        if (auto read = read_can(packet, out); !read)
            return std::unexpected(read.error());
    } else if (interface.link_type == user0) {
        out.bytes.assign(packet.begin(), packet.end());
    } else {
        return std::unexpected(
            fmt::format("a packet of link type {}; 227 (CAN) and 147 (serial) are read", interface.link_type));
    }
    const auto read = for_each_option(body.subspan(fixed + padded(size)),
                                      [&](std::uint16_t code, Bytes value) -> std::expected<void, std::string> {
                                          if (code == comment)
                                              out.discarded = text_of(value);
                                          if (code == packet_flags && value.size() == 4) {
                                              const std::uint32_t direction = number(value, 0, 4) & direction_bits;
                                              if (direction == inbound)
                                                  out.direction = wire::Direction::reply;
                                              if (direction == outbound)
                                                  out.direction = wire::Direction::request;
                                          }
                                          return {};
                                      });
    if (!read)
        return std::unexpected(read.error());
    return out;
}

std::expected<std::optional<Captured>, Error> PcapngReader::next()
{
    while (!broken_) {
        const std::uint64_t here = offset_;
        const auto failed = [&](std::string_view what) {
            return fail(Errc::bad_file, fmt::format("offset {}: {}", here, what));
        };
        std::uint32_t type = 0;
        const auto body = next_block(type);
        if (!body) {
            broken_ = true;
            return failed(body.error());
        }
        if (type == 0 && body->empty() && body->data() == nullptr)
            return std::nullopt;
        at_ += body->size() + block_frame;
        offset_ += body->size() + block_frame;
        if (type == packet_block) {
            auto packet = read_packet(*body);
            if (!packet)
                return failed(packet.error());
            return *std::move(packet);
        }
        std::expected<void, std::string> read;
        if (type == section_block) {
            read = read_section(*body);
            broken_ = !read;
        } else if (type == interface_block) {
            read = read_interface(*body);
        } else if (type == simple_packet) {
            read = std::unexpected("a simple packet block, which has no time");
        }
        if (!read)
            return failed(read.error());
    }
    return std::nullopt;
}

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
        put(body, bus.can ? can_socketcan : user0, 2);
        put(body, 0, 2);
        put(body, 0, 4); // packets are kept whole
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
    put(body, static_cast<std::uint64_t>(known - interfaces_.begin()), 4);
    put(body, static_cast<std::uint64_t>(since) >> 32, 4);
    put(body, static_cast<std::uint64_t>(since) & 0xFFFF'FFFF, 4);
    put(body, packet.size(), 4);
    put(body, packet.size(), 4);
    body += packet;
    body.append(padded(packet.size()) - packet.size(), '\0');
    if (captured.direction) {
        std::string flags;
        put(flags, *captured.direction == wire::Direction::request ? outbound : inbound, 4);
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
