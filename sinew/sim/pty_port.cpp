#include "sinew/sim/pty_port.hpp"

#include <algorithm>

namespace sinew::sim {
namespace {

constexpr std::size_t chunk = 1024; // bytes a read

} // namespace

PtySerialPort::PtySerialPort(std::unique_ptr<link::PtyMaster> pty, SerialWire& wire)
    : PtyPort(std::move(pty)), wire_(&wire)
{
    wire.connect(this);
}

void PtySerialPort::take_in(TimePoint now)
{
    std::array<std::uint8_t, chunk> in;
    // No more than the wire has room for: the rest waits in the terminal, and its program with it.
    while (const std::size_t room = std::min(in.size(), wire_->host_room())) {
        const auto arrival = pty_->read(std::span(in).first(room));
        if (!arrival || arrival->count == 0)
            return;
        wire_->host_sends(std::span(in).first(arrival->count), bit_rate_, now);
    }
}

void PtySerialPort::on_bytes(std::span<const std::uint8_t> bytes, TimePoint)
{
    for (const std::uint8_t byte : bytes.first(std::min(bytes.size(), heard_.size() - heard_size_)))
        heard_[heard_size_++] = byte;
}

void PtySerialPort::hand_out()
{
    if (heard_size_ != 0)
        static_cast<void>(pty_->write(std::span(heard_).first(heard_size_)));
    heard_size_ = 0;
}

PtySlcanPort::PtySlcanPort(std::unique_ptr<link::PtyMaster> pty, CanWire& wire) : PtyPort(std::move(pty)), wire_(&wire)
{
    wire.connect(this);
}

void PtySlcanPort::take_in(TimePoint now)
{
    std::array<std::uint8_t, chunk> in;
    for (;;) {
        const auto arrival = pty_->read(in);
        if (!arrival || arrival->count == 0)
            return;
        adapter_.take(std::span(in).first(arrival->count),
                      [&](const wire::Frame& frame) { wire_->host_sends(frame, adapter_.bit_rate(), now); });
    }
}

void PtySlcanPort::on_frame(const wire::Frame& frame, TimePoint)
{
    adapter_.offer(frame);
}

void PtySlcanPort::hand_out()
{
    if (adapter_.pending().empty())
        return;
    if (const auto written = pty_->write(adapter_.pending()))
        adapter_.drop(*written);
}

} // namespace sinew::sim
