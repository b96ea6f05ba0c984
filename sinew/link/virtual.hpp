#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/link.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

/// Links within this program: one end is the link that a bus owns, the other a simulated wire. What the bus writes goes
/// to the wire's sink at once; what the wire delivers is read once its time has come. No heap after construction, no
/// threads: wire and bus are driven by the same thread.
namespace sinew::link {

/// The wire's end of a `VirtualByteLink`. Must outlive it.
class ByteSink
{
public:
    virtual ~ByteSink() = default;
    /// The bytes start on the wire now, at the rate the link has now. May call `deliver` of the link.
    virtual void on_write(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate) = 0;
    /// The link has hung up or goes away: deliver nothing to it any more.
    virtual void on_close() {}
};

/// The wire's end of a `VirtualCanLink`. Must outlive it.
class CanSink
{
public:
    virtual ~CanSink() = default;
    virtual void on_write(std::span<const wire::Frame> frames, std::uint32_t bit_rate) = 0;
    virtual void on_close() {}
};

/// A queue of runs of items, each run with the one time at which its last item has arrived. Fixed capacity.
template <class Item, std::size_t Items, std::size_t Runs>
class ArrivalQueue
{
public:
    /// All of the run or nothing of it. A run that is earlier than the one before it arrives together with that.
    bool push(std::span<const Item> items, TimePoint at)
    {
        if (items.empty())
            return true;
        if (items.size() > Items - item_count_ || run_count_ == Runs)
            return false;
        if (run_count_ != 0)
            at = std::max(at, runs_[(first_run_ + run_count_ - 1) % Runs].at);
        runs_[(first_run_ + run_count_++) % Runs] = {.count = items.size(), .at = at};
        for (const Item& item : items)
            items_[(first_item_ + item_count_++) % Items] = item;
        return true;
    }

    /// Of the first run, if it has arrived by `now`; what does not fit stays, with the same time.
    Arrival pop(std::span<Item> into, TimePoint now)
    {
        if (run_count_ == 0 || runs_[first_run_].at > now)
            return {.count = 0, .at = now};
        Arrival& run = runs_[first_run_];
        Arrival popped{.count = std::min(into.size(), run.count), .at = run.at};
        for (Item& item : into.first(popped.count)) {
            item = items_[first_item_];
            first_item_ = (first_item_ + 1) % Items;
        }
        item_count_ -= popped.count;
        run.count -= popped.count;
        if (run.count == 0) {
            first_run_ = (first_run_ + 1) % Runs;
            --run_count_;
        }
        popped.more = run_count_ != 0 && runs_[first_run_].at <= now;
        return popped;
    }

    std::optional<TimePoint> next() const
    {
        return run_count_ == 0 ? std::nullopt : std::optional{runs_[first_run_].at};
    }

private:
    std::array<Item, Items> items_{};
    std::array<Arrival, Runs> runs_{};
    std::size_t first_item_ = 0, item_count_ = 0;
    std::size_t first_run_ = 0, run_count_ = 0;
};

/// What both kinds share. `Base` is `ByteLink` or `CanLink`, `Item` what it moves.
template <class Base, class Sink, class Item, std::size_t Items, std::size_t Runs>
class VirtualLink final : public Base
{
public:
    /// Clock and sink must outlive the link.
    VirtualLink(const Clock& clock, Sink& sink, std::uint32_t bit_rate)
        : clock_(&clock), sink_(&sink), bit_rate_(bit_rate)
    {
    }
    ~VirtualLink() override { hang_up(); }
    VirtualLink(const VirtualLink&) = delete;
    VirtualLink& operator=(const VirtualLink&) = delete;

    /// For the wire: these end at `at`, now or later, and are read from then on. False, and counted in `dropped()`,
    /// when nobody reads and the queue is full; also when hung up.
    bool deliver(std::span<const Item> items, TimePoint at)
    {
        if (open_ && arrivals_.push(items, at))
            return true;
        dropped_ += items.size();
        return false;
    }
    /// For the wire: unplugs; what was not read is gone. The sink is told.
    void hang_up()
    {
        if (std::exchange(open_, false))
            sink_->on_close();
    }
    /// For the clock: when the next read brings something; it may be in the past.
    std::optional<TimePoint> next_arrival() const { return open_ ? arrivals_.next() : std::nullopt; }
    std::uint64_t dropped() const { return dropped_; }

    std::expected<std::size_t, Error> write(std::span<const Item> items) override
    {
        if (!open_)
            return lost();
        if (!items.empty())
            sink_->on_write(items, bit_rate_);
        return items.size();
    }
    /// One run at a time: each has its own time of arrival.
    std::expected<Arrival, Error> read(std::span<Item> into) override
    {
        if (!open_)
            return lost();
        return arrivals_.pop(into, clock_->now());
    }
    int handle() const override { return -1; }
    LinkState state() const override { return {.open = open_, .bit_rate = bit_rate_}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override
    {
        if (!open_)
            return lost();
        if (bit_rate == 0)
            return fail(Errc::unsupported, "a bit rate of 0 moves nothing");
        return bit_rate_ = bit_rate;
    }

private:
    static std::unexpected<Error> lost() { return fail(Errc::link_lost, "the simulated wire was unplugged"); }

    const Clock* clock_;
    Sink* sink_;
    std::uint32_t bit_rate_;
    bool open_ = true;
    std::uint64_t dropped_ = 0;
    ArrivalQueue<Item, Items, Runs> arrivals_;
};

using VirtualByteLink = VirtualLink<ByteLink, ByteSink, std::uint8_t, 4096, 1024>;
using VirtualCanLink = VirtualLink<CanLink, CanSink, wire::Frame, 1024, 1024>;

} // namespace sinew::link
