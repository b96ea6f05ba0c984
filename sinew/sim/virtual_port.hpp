#pragma once
#include "sinew/link/virtual.hpp"
#include "sinew/sim/virtual_clock.hpp"

namespace sinew::sim {

/// Where a virtual link meets a bus of a world. One link at a time.
class VirtualPort : public Inbox
{
public:
    /// `link_busy` while another link of this bus is open. The port must outlive the link.
    virtual std::expected<link::AnyLink, Error> open(const link::Clock& clock) = 0;
    virtual const WorldBus& bus() const = 0;
    /// The host's adapter goes or comes back: an open link hangs up, and none opens until then.
    virtual void set_plugged(bool plugged) = 0;
};

/// The port of one kind of wire: what a `SerialPort` and a `CanPort` share.
template <class Link, class Wire>
class PortOf : public VirtualPort
{
public:
    PortOf(World& world, WorldBus& bus) : world_(&world), bus_(&bus), wire_(&std::get<Wire>(bus.wire)) {}

    const WorldBus& bus() const override { return *bus_; }
    void set_plugged(bool plugged) override
    {
        plugged_ = plugged;
        if (!plugged && link_ != nullptr)
            link_->hang_up();
    }

    bool has_news() override
    {
        const auto next = link_ != nullptr ? link_->next_arrival() : std::nullopt;
        const bool is_new = next && *next <= world_->now() && (next != told_ || delivered_since_);
        told_ = next;
        delivered_since_ = false;
        return is_new;
    }

protected:
    template <class Sink, class Base>
    std::expected<link::AnyLink, Error> open_as(const link::Clock& clock, Sink& sink)
    {
        if (!plugged_)
            return fail(Errc::link_not_found, "the adapter of the simulated bus '" + bus_->name + "' is unplugged");
        if (link_ != nullptr)
            return fail(Errc::link_busy, "the simulated bus '" + bus_->name + "' is already open");
        auto link = std::make_unique<Link>(clock, sink, bus_->bit_rate);
        link_ = link.get();
        return std::unique_ptr<Base>(std::move(link));
    }
    void close()
    {
        wire_->connect(nullptr);
        link_ = nullptr;
    }
    template <class Items>
    void deliver(Items items, TimePoint at)
    {
        delivered_since_ |= link_->deliver(items, at);
    }
    std::uint32_t link_bit_rate() const { return link_->state().bit_rate; }

    World* world_;
    WorldBus* bus_;
    Wire* wire_;
    Link* link_ = nullptr;

private:
    bool plugged_ = true;
    std::optional<TimePoint> told_;
    bool delivered_since_ = false;
};

class SerialPort final : public PortOf<link::VirtualByteLink, SerialWire>, private SerialHost, private link::ByteSink
{
public:
    using PortOf::PortOf;

    std::expected<link::AnyLink, Error> open(const link::Clock& clock) override
    {
        auto opened = open_as<link::ByteSink, link::ByteLink>(clock, *this);
        if (opened)
            wire_->connect(this);
        return opened;
    }

private:
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate) override
    {
        wire_->host_sends(bytes, bit_rate, world_->now());
    }
    void on_close() override { close(); }
    std::uint32_t bit_rate() const override { return link_bit_rate(); }
    void on_bytes(std::span<const std::uint8_t> bytes, TimePoint at) override { deliver(bytes, at); }
};

class CanPort final : public PortOf<link::VirtualCanLink, CanWire>, private CanHost, private link::CanSink
{
public:
    using PortOf::PortOf;

    std::expected<link::AnyLink, Error> open(const link::Clock& clock) override
    {
        auto opened = open_as<link::CanSink, link::CanLink>(clock, *this);
        if (opened)
            wire_->connect(this);
        return opened;
    }

private:
    void on_write(std::span<const wire::Frame> frames, std::uint32_t bit_rate) override
    {
        for (const wire::Frame& frame : frames)
            wire_->host_sends(frame, bit_rate, world_->now());
    }
    void on_close() override { close(); }
    std::uint32_t bit_rate() const override { return link_bit_rate(); }
    void on_frame(const wire::Frame& frame, TimePoint at) override { deliver(std::span(&frame, 1), at); }
};

} // namespace sinew::sim
