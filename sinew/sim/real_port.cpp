#include "sinew/sim/real_port.hpp"

#include "sinew/link/pty.hpp"
#include "sinew/link/tcp.hpp"
#include "sinew/link/uri.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

namespace sinew::sim {
namespace {

constexpr std::size_t chunk = 1024; // bytes a read

/// Of a terminal whose program sets none; for a CAN adapter it means nothing.
constexpr std::uint32_t adapter_bit_rate = 115'200;

struct Address {
    std::string host;
    std::uint16_t port = 0;
};

std::expected<Address, Error> address_of(const link::Uri& uri)
{
    const std::string_view target = uri.target;
    const auto colon = target.rfind(':');
    std::string_view host = target.substr(0, std::min(colon, target.size()));
    const std::string_view port = colon == std::string_view::npos ? "" : target.substr(colon + 1);
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    Address address{.host = std::string(host == "localhost" ? "127.0.0.1" : host)};
    const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    if (host.empty() || problem != std::errc{} || end != port.data() + port.size())
        return fail(Errc::bad_uri, fmt::format("'{}' must be written tcp://ADDRESS:PORT, such as tcp://127.0.0.1:4001",
                                               to_string(uri)));
    return address;
}

std::expected<OpenedPort, Error> open_pty(WorldBus& bus, const link::Clock& clock)
{
    auto* can = std::get_if<CanWire>(&bus.wire);
    auto pty = link::PtyMaster::open(can != nullptr ? adapter_bit_rate : bus.bit_rate, clock);
    if (!pty)
        return std::unexpected(std::move(pty.error()));
    const std::string device = (*pty)->device();
    if (can != nullptr)
        return OpenedPort{std::make_unique<RealSlcanPort>(std::move(*pty), *can),
                          fmt::format("slcan:{}?bitrate={}", device, bus.bit_rate)};
    return OpenedPort{std::make_unique<RealBytePort>(std::move(*pty), std::get<SerialWire>(bus.wire), bus.bit_rate),
                      fmt::format("serial:{}?baud={}", device, bus.bit_rate)};
}

std::expected<OpenedPort, Error> open_tcp(WorldBus& bus, const link::Uri& uri, const link::Clock& clock)
{
    const auto address = address_of(uri);
    if (!address)
        return std::unexpected(address.error());
    auto listener = link::TcpListener::open(address->host, address->port, clock);
    if (!listener)
        return std::unexpected(std::move(listener.error()));
    const bool is_ipv6 = address->host.find(':') != std::string::npos;
    const std::string link = fmt::format("tcp://{}:{}?baud={}", is_ipv6 ? '[' + address->host + ']' : address->host,
                                         (*listener)->port(), bus.bit_rate);
    return OpenedPort{
        std::make_unique<RealBytePort>(std::move(*listener), std::get<SerialWire>(bus.wire), bus.bit_rate), link};
}

std::expected<OpenedPort, Error> open_can(WorldBus& bus, const link::Uri& uri, const link::Clock& clock)
{
    auto link = link::SocketCanLink::open({.interface = uri.target}, clock);
    if (!link)
        return std::unexpected(std::move(link.error()));
    const bool has_rate = (*link)->state().bit_rate != 0;
    return OpenedPort{std::make_unique<RealCanPort>(std::move(*link), std::get<CanWire>(bus.wire), bus.bit_rate, clock),
                      fmt::format("can:{}{}", uri.target, has_rate ? "" : fmt::format("?bitrate={}", bus.bit_rate))};
}

} // namespace

RealBytePort::RealBytePort(std::unique_ptr<link::ByteLink> end, SerialWire& wire, std::uint32_t bit_rate)
    : end_(std::move(end)), wire_(&wire), bit_rate_(bit_rate), own_bit_rate_(bit_rate)
{
    wire.connect(this);
}

void RealBytePort::refresh()
{
    const std::uint32_t set = end_->state().bit_rate;
    bit_rate_ = set != 0 ? set : own_bit_rate_;
}

void RealBytePort::take_in(TimePoint now)
{
    std::array<std::uint8_t, chunk> in;
    // No more than the wire has room for: the rest waits in the terminal, and its program with it.
    while (const std::size_t room = std::min(in.size(), wire_->host_room())) {
        const auto arrival = end_->read(std::span(in).first(room));
        if (!arrival || arrival->count == 0)
            return;
        const auto bytes = std::span(in).first(arrival->count);
        wire_->host_sends(bytes, bit_rate_, now);
        tell(wire::Direction::request, bytes, now);
    }
}

void RealBytePort::on_bytes(std::span<const std::uint8_t> bytes, TimePoint at)
{
    tell(wire::Direction::reply, bytes, at);
    for (const std::uint8_t byte : bytes.first(std::min(bytes.size(), heard_.size() - heard_size_)))
        heard_[heard_size_++] = byte;
}

void RealBytePort::hand_out()
{
    if (heard_size_ != 0)
        static_cast<void>(end_->write(std::span(heard_).first(heard_size_)));
    heard_size_ = 0;
}

RealSlcanPort::RealSlcanPort(std::unique_ptr<link::ByteLink> end, CanWire& wire) : end_(std::move(end)), wire_(&wire)
{
    wire.connect(this);
}

void RealSlcanPort::take_in(TimePoint now)
{
    std::array<std::uint8_t, chunk> in;
    const std::uint64_t errors = wire_->counters().error_frames;
    if (std::exchange(errors_noted_, errors) != errors)
        adapter_.note(link::slcan::flag::bus_error);
    for (;;) {
        const auto arrival = end_->read(in);
        if (!arrival || arrival->count == 0)
            return;
        adapter_.take(std::span(in).first(arrival->count), [&](const wire::Frame& frame) {
            const bool sent = wire_->host_sends(frame, adapter_.bit_rate(), now);
            if (sent)
                tell(wire::Direction::request, frame, now);
            return sent;
        });
    }
}

void RealSlcanPort::on_frame(const wire::Frame& frame, TimePoint at)
{
    tell(wire::Direction::reply, frame, at);
    adapter_.offer(frame);
}

void RealSlcanPort::hand_out()
{
    if (adapter_.pending().empty())
        return;
    if (const auto written = end_->write(adapter_.pending()))
        adapter_.drop(*written);
}

RealCanPort::RealCanPort(std::unique_ptr<link::SocketCanLink> link, CanWire& wire, std::uint32_t bit_rate,
                         const link::Clock& clock)
    : link_(std::move(link)), wire_(&wire), own_bit_rate_(bit_rate), clock_(&clock)
{
    wire.connect(this);
}

std::uint32_t RealCanPort::bit_rate() const
{
    const std::uint32_t set = link_->state().bit_rate;
    return set != 0 ? set : own_bit_rate_;
}

void RealCanPort::refresh()
{
    if (!is_lost_ || clock_->now() < reopen_at_)
        return;
    reopen_at_ = clock_->now() + reopen_every;
    auto link = link::SocketCanLink::open({.interface = link_->interface()}, *clock_);
    if (!link)
        return;
    link_ = std::move(*link);
    is_lost_ = false;
    news_ = link_->interface() + " is back";
}

void RealCanPort::lost(const Error& error)
{
    if (link_->state().open || is_lost_)
        return;
    is_lost_ = true;
    reopen_at_ = clock_->now() + reopen_every;
    heard_size_ = 0;
    news_ = to_sentence(error);
}

void RealCanPort::take_in(TimePoint now)
{
    while (wire_->host_room() != 0) {
        wire::Frame frame;
        const auto arrival = link_->read({&frame, 1});
        if (!arrival)
            return lost(arrival.error());
        if (arrival->count == 0)
            return;
        wire_->host_sends(frame, bit_rate(), now);
        tell(wire::Direction::request, frame, now);
    }
}

void RealCanPort::on_frame(const wire::Frame& frame, TimePoint at)
{
    tell(wire::Direction::reply, frame, at);
    if (heard_size_ < heard_.size())
        heard_[heard_size_++] = frame;
}

void RealCanPort::hand_out()
{
    if (heard_size_ == 0)
        return;
    const auto taken = link_->write(std::span(heard_).first(heard_size_));
    if (!taken)
        return lost(taken.error());
    std::copy(heard_.begin() + *taken, heard_.begin() + heard_size_, heard_.begin());
    heard_size_ -= *taken;
}

std::expected<OpenedPort, Error> open_port(WorldBus& bus, const std::string& place, const link::Clock& clock)
{
    if (place.empty())
        return open_pty(bus, clock);
    const auto uri = link::parse_uri(place);
    if (!uri)
        return std::unexpected(uri.error());
    const bool is_can = std::holds_alternative<CanWire>(bus.wire);
    if (uri->scheme == "tcp" && !is_can)
        return open_tcp(bus, *uri, clock);
    if (uri->scheme == "can" && is_can)
        return open_can(bus, *uri, clock);
    return fail(Errc::bad_uri,
                fmt::format("bus {} cannot be simulated at {}: {}", bus.name, place,
                            is_can ? "CAN buses are reached by can:INTERFACE, or by an SLCAN adapter where no link is "
                                     "given"
                                   : "serial buses are reached by tcp://ADDRESS:PORT, or by a pseudo terminal where no "
                                     "link is given"));
}

} // namespace sinew::sim
