#pragma once
#include "sinew/link/slcan_adapter.hpp"
#include "sinew/link/socketcan.hpp"
#include "sinew/sim/world.hpp"

#include <array>
#include <functional>
#include <memory>
#include <string>

namespace sinew::sim {

/// Where programs outside meet a bus of a world, in real time.
class RealPort
{
public:
    virtual ~RealPort() = default;

    /// For ppoll; -1 while the wire is full and the program has to wait. It may change: ask before every wait.
    virtual int handle() const = 0;
    /// Looks at what is outside, the rate that the program has set, say: once for all that follows, for it is a system
    /// call.
    virtual void refresh() {}
    /// Puts on the wire what the program wrote.
    virtual void take_in(TimePoint now) = 0;
    /// Hands the program what the wire brought. What it does not fetch is lost once its end is full.
    virtual void hand_out() = 0;
    /// A sentence for a person, once: what happened outside. Empty: nothing.
    virtual std::string news() { return {}; }

    /// Told of all that programs send and are sent: bytes, or a CAN frame.
    using Tap = std::function<void(wire::Direction, std::span<const std::uint8_t> bytes, const wire::Frame* frame,
                                   TimePoint at)>;
    void set_tap(Tap tap) { tap_ = std::move(tap); }

protected:
    void tell(wire::Direction direction, std::span<const std::uint8_t> bytes, TimePoint at)
    {
        if (tap_)
            tap_(direction, bytes, nullptr, at);
    }
    void tell(wire::Direction direction, const wire::Frame& frame, TimePoint at)
    {
        if (tap_)
            tap_(direction, {}, &frame, at);
    }

private:
    Tap tap_;
};

/// A serial bus behind a pseudo terminal or a TCP port.
class RealBytePort final : public RealPort, private SerialHost
{
public:
    /// `bit_rate` is what the wire hears of an end that has none (TCP).
    RealBytePort(std::unique_ptr<link::ByteLink> end, SerialWire& wire, std::uint32_t bit_rate);

    int handle() const override { return has_room() ? end_->handle() : -1; }
    void refresh() override;
    void take_in(TimePoint now) override;
    void hand_out() override;

private:
    bool has_room() const { return wire_->host_room() >= SerialWire::host_capacity / 2; }
    std::uint32_t bit_rate() const override { return bit_rate_; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) override;

    std::unique_ptr<link::ByteLink> end_;
    SerialWire* wire_;
    std::uint32_t bit_rate_;
    std::uint32_t own_bit_rate_;
    std::array<std::uint8_t, 4096> heard_{}; ///< between two calls of `hand_out`
    std::size_t heard_size_ = 0;
};

/// A CAN bus behind an SLCAN adapter on a pseudo terminal.
class RealSlcanPort final : public RealPort, private CanHost
{
public:
    RealSlcanPort(std::unique_ptr<link::ByteLink> end, CanWire& wire);

    int handle() const override { return end_->handle(); }
    void take_in(TimePoint now) override;
    void hand_out() override;

private:
    std::uint32_t bit_rate() const override { return adapter_.is_open() ? adapter_.bit_rate() : 0; }
    void on_frame(const wire::Frame& frame, TimePoint at) override;

    std::unique_ptr<link::ByteLink> end_;
    CanWire* wire_;
    link::SlcanAdapter adapter_;
    std::uint64_t errors_noted_ = 0;
};

/// A CAN bus on an interface of Linux, where it is one more peer: its devices hear what all programs there send. An
/// interface that goes down or is removed comes back by itself once it is there again; meanwhile the bus is silent.
class RealCanPort final : public RealPort, private CanHost
{
public:
    /// `bit_rate` is what the wire hears of an interface that has none (vcan). The clock must outlive the port.
    RealCanPort(std::unique_ptr<link::SocketCanLink> link, CanWire& wire, std::uint32_t bit_rate,
                const link::Clock& clock);

    int handle() const override { return wire_->host_room() != 0 ? link_->handle() : -1; }
    void refresh() override;
    void take_in(TimePoint now) override;
    void hand_out() override;
    std::string news() override { return std::exchange(news_, {}); }

    static constexpr Duration reopen_every = std::chrono::milliseconds{100};

private:
    std::uint32_t bit_rate() const override;
    void on_frame(const wire::Frame& frame, TimePoint at) override;
    void lost(const Error& error);

    std::unique_ptr<link::SocketCanLink> link_;
    CanWire* wire_;
    std::uint32_t own_bit_rate_;
    const link::Clock* clock_;
    bool is_lost_ = false;
    TimePoint reopen_at_{};
    std::string news_;
    std::array<wire::Frame, CanWire::host_capacity> heard_{}; ///< that wait for the interface to take them
    std::size_t heard_size_ = 0;
};

/// A port with the link by which a program reaches it.
struct OpenedPort {
    std::unique_ptr<RealPort> port;
    std::string link;
};

/// Opens the port of a bus. `place` is the link by which it is to be reached, `tcp://ADDRESS:PORT` (0: any free port;
/// serial buses) or `can:INTERFACE` (CAN buses); empty: a pseudo terminal, on CAN an SLCAN adapter. `bad_uri` where the
/// place is of the wrong kind; the errors of the link.
std::expected<OpenedPort, Error> open_port(WorldBus& bus, const std::string& place, const link::Clock& clock);

} // namespace sinew::sim
