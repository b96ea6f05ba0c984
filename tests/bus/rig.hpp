#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/link/virtual.hpp"
#include "sinew/sim/wire/can_wire.hpp"
#include "sinew/sim/wire/serial_wire.hpp"

#include <cassert>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

/// Buses on the simulator's wires in virtual time, with devices of the test's own.
namespace sinew::tests {

/// What a clock must know of a wire and of the link on it.
class Port
{
public:
    virtual ~Port() = default;
    virtual TimePoint next_event() const = 0;
    virtual void run_until(TimePoint until) = 0;
    virtual std::optional<TimePoint> next_arrival() const = 0;
};

/// Time that passes only where somebody waits, shared by all wires.
class WireClock final : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        for (;;) {
            TimePoint arrival = TimePoint::max();
            TimePoint event = TimePoint::max();
            for (const Port* port : ports_) {
                arrival = std::min(arrival, port->next_arrival().value_or(TimePoint::max()));
                event = std::min(event, port->next_event());
            }
            if (arrival <= now_)
                return;
            const TimePoint next = std::min(arrival, event);
            const bool over = next > deadline;
            assert(!over || deadline != TimePoint::max());
            advance(over ? deadline : next);
            if (over)
                return;
        }
    }
    void watch(Port& port) { ports_.push_back(&port); }

private:
    void advance(TimePoint to)
    {
        now_ = std::max(now_, to);
        for (Port* port : ports_)
            port->run_until(now_);
    }

    TimePoint now_{std::chrono::seconds(1)};
    std::vector<Port*> ports_;
};

/// Something that happens while the one who drives waits, and wakes him as the descriptor of a stop does.
class Alarm final : public Port
{
public:
    explicit Alarm(WireClock& clock) { clock.watch(*this); }
    void set(TimePoint at, std::function<void()> what)
    {
        at_ = at;
        what_ = std::move(what);
    }
    /// Now, if it has not happened yet.
    void make_up_for_it()
    {
        if (at_ != TimePoint::max())
            run_until(at_);
    }

    TimePoint next_event() const override { return at_; }
    void run_until(TimePoint until) override
    {
        if (until < at_)
            return;
        woke_ = std::exchange(at_, TimePoint::max());
        what_();
    }
    std::optional<TimePoint> next_arrival() const override { return std::exchange(woke_, std::nullopt); }

private:
    TimePoint at_ = TimePoint::max();
    mutable std::optional<TimePoint> woke_;
    std::function<void()> what_;
};

/// A device: answers what `answer` says, `delay` after the request.
class Station final : public sim::Station
{
public:
    using Answer = std::function<std::optional<sim::Answer>(const wire::Frame& request, TimePoint at)>;

    Station(const wire::Protocol& protocol, int id, std::uint32_t bit_rate, Answer answer)
        : protocol_(protocol), id_(id), bit_rate_(bit_rate), answer_(std::move(answer))
    {
    }
    std::optional<sim::Answer> hear(const wire::Frame& request, TimePoint at) override { return answer_(request, at); }
    void answered(TimePoint) override {}
    const wire::Protocol& protocol() const override { return protocol_; }
    int id() const override { return id_; }
    std::uint32_t bit_rate() const override { return is_plugged ? bit_rate_ : 0; }

    bool is_plugged = true;

private:
    const wire::Protocol& protocol_;
    int id_;
    std::uint32_t bit_rate_;
    Answer answer_;
};

/// A serial wire with its devices and a bus on it.
class SerialRig final : public Port, private sim::SerialHost, private link::ByteSink
{
public:
    SerialRig(WireClock& clock, const wire::Protocol& protocol, std::uint32_t bit_rate, bus::Settings settings = {})
        : clock_(clock), protocol_(protocol), bit_rate_(bit_rate),
          wire(protocol.bare_replies() ? sim::Duplex::full : sim::Duplex::half)
    {
        wire.connect(this);
        clock.watch(*this);
        bus.emplace("rig", plug_in(), clock, protocol, settings);
    }
    void add(int id, Station::Answer answer)
    {
        stations.push_back(std::make_unique<Station>(protocol_, id, bit_rate_, std::move(answer)));
        wire.attach(*stations.back());
    }
    void unplug_host() { link_->hang_up(); }
    link::AnyLink plug_in()
    {
        auto made = std::make_unique<link::VirtualByteLink>(clock_, static_cast<link::ByteSink&>(*this), bit_rate_);
        link_ = made.get();
        return std::unique_ptr<link::ByteLink>{std::move(made)};
    }

    TimePoint next_event() const override { return wire.next_event(); }
    void run_until(TimePoint until) override { wire.run_until(until); }
    std::optional<TimePoint> next_arrival() const override { return link_->next_arrival(); }

private:
    std::uint32_t bit_rate() const override { return bit_rate_; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) override { link_->deliver(bytes, at); }
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate) override
    {
        wire.host_sends(bytes, bit_rate, clock_.now());
    }

    WireClock& clock_;
    const wire::Protocol& protocol_;
    std::uint32_t bit_rate_;
    link::VirtualByteLink* link_ = nullptr;

public:
    sim::SerialWire wire;
    std::vector<std::unique_ptr<Station>> stations;
    std::optional<bus::Bus> bus;
};

/// A CAN bus with its devices and a bus on it.
class CanRig final : public Port, private sim::CanHost, private link::CanSink
{
public:
    CanRig(WireClock& clock, std::uint32_t bit_rate, bus::Settings settings = {}) : clock_(clock), bit_rate_(bit_rate)
    {
        wire.connect(this);
        clock.watch(*this);
        bus.emplace("rig", plug_in(), clock, rmd::protocol(), settings);
    }
    void add(int id, Station::Answer answer)
    {
        stations.push_back(std::make_unique<Station>(rmd::protocol(), id, bit_rate_, std::move(answer)));
        wire.attach(*stations.back());
    }
    void unplug_host() { link_->hang_up(); }
    link::AnyLink plug_in()
    {
        auto made = std::make_unique<link::VirtualCanLink>(clock_, static_cast<link::CanSink&>(*this), bit_rate_);
        link_ = made.get();
        return std::unique_ptr<link::CanLink>{std::move(made)};
    }

    TimePoint next_event() const override { return wire.next_event(); }
    void run_until(TimePoint until) override { wire.run_until(until); }
    std::optional<TimePoint> next_arrival() const override { return link_->next_arrival(); }

    std::int64_t bits = 0; ///< of all frames of the host and of what it heard, with the space behind them

private:
    std::uint32_t bit_rate() const override { return bit_rate_; }
    void on_frame(const wire::Frame& frame, TimePoint at) override
    {
        bits += sim::can_frame_bits(frame) + sim::can_interframe_bits;
        link_->deliver(std::span(&frame, 1), at);
    }
    void on_write(std::span<const wire::Frame> frames, std::uint32_t bit_rate) override
    {
        for (const auto& frame : frames) {
            bits += sim::can_frame_bits(frame) + sim::can_interframe_bits;
            wire.host_sends(frame, bit_rate, clock_.now());
        }
    }

    WireClock& clock_;
    std::uint32_t bit_rate_;
    link::VirtualCanLink* link_ = nullptr;

public:
    sim::CanWire wire;
    std::vector<std::unique_ptr<Station>> stations;
    std::optional<bus::Bus> bus;
};

} // namespace sinew::tests
