#pragma once
#include "sinew/link/pty.hpp"
#include "sinew/link/slcan_adapter.hpp"
#include "sinew/sim/world.hpp"

#include <array>

namespace sinew::sim {

/// Where a pseudo terminal meets a bus of a world.
class PtyPort
{
public:
    explicit PtyPort(std::unique_ptr<link::PtyMaster> pty) : pty_(std::move(pty)) {}
    virtual ~PtyPort() = default;

    /// For ppoll; -1 while the wire is full and the program has to wait.
    int handle() const { return has_room() ? pty_->handle() : -1; }
    /// Looks at the rate that the program has set: once for all that follows, for it is a system call.
    virtual void refresh() {}
    /// Puts on the wire what the program wrote.
    virtual void take_in(TimePoint now) = 0;
    /// Hands the program what the wire brought. What it does not fetch is lost once the terminal is full.
    virtual void hand_out() = 0;

protected:
    virtual bool has_room() const { return true; }

    std::unique_ptr<link::PtyMaster> pty_;
};

class PtySerialPort final : public PtyPort, private SerialHost
{
public:
    PtySerialPort(std::unique_ptr<link::PtyMaster> pty, SerialWire& wire);

    void refresh() override { bit_rate_ = pty_->client_bit_rate(); }
    void take_in(TimePoint now) override;
    void hand_out() override;

private:
    bool has_room() const override { return wire_->host_room() >= SerialWire::host_capacity / 2; }
    std::uint32_t bit_rate() const override { return bit_rate_; }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) override;

    SerialWire* wire_;
    std::uint32_t bit_rate_ = 0;
    std::array<std::uint8_t, 4096> heard_{}; ///< between two calls of `hand_out`
    std::size_t heard_size_ = 0;
};

class PtySlcanPort final : public PtyPort, private CanHost
{
public:
    PtySlcanPort(std::unique_ptr<link::PtyMaster> pty, CanWire& wire);

    void take_in(TimePoint now) override;
    void hand_out() override;

private:
    std::uint32_t bit_rate() const override { return adapter_.is_open() ? adapter_.bit_rate() : 0; }
    void on_frame(const wire::Frame& frame, TimePoint at) override;

    CanWire* wire_;
    link::SlcanAdapter adapter_;
};

} // namespace sinew::sim
