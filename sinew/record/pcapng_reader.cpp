#include "sinew/record/little_endian.hpp"
#include "sinew/record/pcapng.hpp"
#include "sinew/record/pcapng_format.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>

namespace sinew::record {
namespace {

using namespace pcapng;

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
                out.name = std::string(text_of(value));
            if (code == description)
                out.family = std::string(text_of(value));
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
                                              out.discarded = std::string(text_of(value));
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

} // namespace sinew::record
