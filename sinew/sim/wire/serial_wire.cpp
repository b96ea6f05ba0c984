#include "sinew/sim/wire/serial_wire.hpp"

namespace sinew::sim {
namespace {

Duration longest_pause(std::uint32_t bit_rate)
{
    return std::max<Duration>(std::chrono::milliseconds{5}, bit_time(20 * bits_per_byte, bit_rate));
}

} // namespace

void SerialWire::attach(Station& station)
{
    connections_.emplace_back(station);
}

std::size_t SerialWire::host_sends(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate, TimePoint now)
{
    return bit_rate == 0 ? bytes.size() : host_out_.send(bytes, bit_rate, now);
}

TimePoint SerialWire::next_event() const
{
    TimePoint next = std::min({host_out_.next_start(), lines_[0].next_event(), lines_[1].next_event()});
    for (const Connection& connection : connections_)
        next = std::min({next, connection.out.next_start(), connection.gives_up});
    return next;
}

void SerialWire::run_until(TimePoint until)
{
    for (TimePoint at = next_event(); at <= until && at != TimePoint::max(); at = next_event())
        step(at);
}

void SerialWire::step(TimePoint at)
{
    // Ends before starts: bytes of one talker follow each other without a gap and must not be taken for a collision.
    for (Line& line : lines_)
        if (line.next_event() <= at)
            finish(line);
    for (Connection& connection : connections_)
        if (connection.gives_up <= at)
            find_requests(connection, true, at);
    if (host_out_.next_start() <= at)
        start(host_out_, from_host());
    for (Connection& connection : connections_)
        if (connection.out.next_start() <= at)
            start(connection.out, from_stations());
}

void SerialWire::start(Transmitter& transmitter, Line& line)
{
    const Transmitter::Byte byte = transmitter.start();
    if (line.busy)
        line.byte.value &= byte.value;
    else
        line = {.busy = true, .byte = byte};
}

void SerialWire::finish(Line& line)
{
    line.busy = false;
    const Transmitter::Byte byte = line.byte;
    const auto hears = [&](const Transmitter& own) {
        return duplex_ == Duplex::full || own.busy_until() <= byte.start;
    };
    for (Connection& connection : connections_)
        if (connection.answering && connection.out.idle_after(byte.end)) {
            connection.answering = false;
            connection.station->answered(byte.end);
        }
    if (&line == &from_host())
        for (Connection& connection : connections_)
            if (hears(connection.out))
                hear(connection, byte);
    if (&line == &from_stations() && host_ != nullptr && hears(host_out_) && host_->bit_rate() == byte.bit_rate)
        host_->on_bytes({&byte.value, 1}, byte.end);
}

void SerialWire::hear(Connection& connection, const Transmitter::Byte& byte)
{
    if (connection.station->bit_rate() != byte.bit_rate)
        return;
    connection.in.add(byte.value);
    connection.gives_up = byte.end + longest_pause(byte.bit_rate);
    find_requests(connection, false, byte.end);
}

void SerialWire::find_requests(Connection& connection, bool silent, TimePoint at)
{
    Station& station = *connection.station;
    while (!connection.in.empty()) {
        const auto bytes = connection.in.bytes();
        const wire::Scan scan = station.protocol().find_request(bytes, silent);
        wire::Frame request;
        const bool is_frame = scan.size != 0 && scan.size <= wire::Frame::capacity;
        if (is_frame) {
            request.size = static_cast<std::uint8_t>(scan.size);
            std::ranges::copy(bytes.subspan(scan.skip, scan.size), request.data.begin());
        }
        connection.in.drop(scan.skip + scan.size);
        if (scan.size == 0)
            break;
        if (!is_frame)
            continue;
        // A message that changes the rate is still answered at the old one.
        const std::uint32_t bit_rate = station.bit_rate();
        const auto answer = station.hear(request, at);
        if (answer && answer->frame.size <= connection.out.room())
            connection.answering = connection.out.send(answer->frame.bytes(), bit_rate, at + answer->delay) != 0;
    }
    if (silent)
        connection.in.drop(connection.in.bytes().size());
    if (connection.in.empty())
        connection.gives_up = TimePoint::max();
}

} // namespace sinew::sim
