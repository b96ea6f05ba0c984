#pragma once
#include "sinew/base/time.hpp"
#include "sinew/sim/wire/ring.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

/// The two halves of a UART, 8N1: what one end of a serial wire sends, and what it has heard.
namespace sinew::sim {

inline constexpr std::int64_t bits_per_byte = 10; ///< start, eight data bits, stop

/// Sends bytes one after the other. Those that follow each other without a pause keep to the bit grid of the first, so
/// that rounding to nanoseconds does not add up.
class Transmitter
{
public:
    struct Byte {
        std::uint8_t value = 0;
        std::uint32_t bit_rate = 0;
        TimePoint start{};
        TimePoint end{};
    };

    explicit Transmitter(std::size_t capacity) : waiting_(capacity) {}

    /// Queues bytes that do not start before `from`; returns how many fit.
    std::size_t send(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate, TimePoint from)
    {
        const auto fitting = bytes.first(std::min(bytes.size(), waiting_.room()));
        for (const std::uint8_t value : fitting)
            waiting_.push({.value = value, .bit_rate = bit_rate, .from = from});
        return fitting.size();
    }
    std::size_t room() const { return waiting_.room(); }

    /// When the next byte goes out; `TimePoint::max()`: none waits.
    TimePoint next_start() const
    {
        return waiting_.empty() ? TimePoint::max() : std::max(waiting_.front().from, free_);
    }
    /// Puts the next byte on the line.
    Byte start()
    {
        const Waiting next = waiting_.front();
        waiting_.pop();
        if (next.bit_rate != bit_rate_ || next.from > free_) {
            bit_rate_ = next.bit_rate;
            burst_ = free_ = std::max(next.from, free_);
            sent_ = 0;
        }
        const TimePoint start = free_;
        free_ = burst_ + bit_time(bits_per_byte * ++sent_, bit_rate_);
        return {.value = next.value, .bit_rate = next.bit_rate, .start = start, .end = free_};
    }
    /// When the line is its own no more.
    TimePoint busy_until() const { return free_; }

private:
    struct Waiting {
        std::uint8_t value = 0;
        std::uint32_t bit_rate = 0;
        TimePoint from{};
    };

    Ring<Waiting> waiting_;
    TimePoint burst_{}; ///< start of the first byte since the last pause
    TimePoint free_{};
    std::int64_t sent_ = 0;
    std::uint32_t bit_rate_ = 0;
};

/// What a device has heard and not yet understood. When it is full the oldest byte is lost; no framing waits for that
/// many.
class Receiver
{
public:
    static constexpr std::size_t capacity = 64;

    std::span<const std::uint8_t> bytes() const { return std::span(bytes_).first(size_); }
    /// When the byte at this place began.
    TimePoint start(std::size_t place) const { return starts_[place]; }
    bool empty() const { return size_ == 0; }
    void add(std::uint8_t byte, TimePoint start)
    {
        if (size_ == capacity)
            drop(1);
        bytes_[size_] = byte;
        starts_[size_++] = start;
    }
    void drop(std::size_t count)
    {
        if (count == size_) {
            size_ = 0;
            return;
        }
        std::copy(bytes_.begin() + count, bytes_.begin() + size_, bytes_.begin());
        std::copy(starts_.begin() + count, starts_.begin() + size_, starts_.begin());
        size_ -= count;
    }

private:
    std::array<std::uint8_t, capacity> bytes_{};
    std::array<TimePoint, capacity> starts_{};
    std::size_t size_ = 0;
};

/// The receiving half of a UART on a waveform that need not be made for it: it waits for a fall, looks whether the
/// middle of the start bit is low, and samples every bit in its middle.
class Sampler
{
public:
    /// The line has this level from `from` to `to`, which follows what was fed before or a silence. Calls
    /// `heard(value, broken, start)` for each byte whose stop bit was sampled; broken: the stop bit was missing.
    template <class F>
    void feed(bool level, TimePoint from, TimePoint to, std::uint32_t bit_rate, F&& heard)
    {
        if (!receiving_ && level_ && !level) {
            receiving_ = true;
            start_ = from;
            next_ = 0;
            value_ = 0;
        }
        level_ = level;
        while (receiving_ && start_ + bit_time(2 * next_ + 1, 2 * std::int64_t{bit_rate}) < to) {
            const int bit = next_++;
            if (bit == 0)
                receiving_ = !level; // else it was a spike
            else if (bit < stop_bit)
                value_ |= static_cast<unsigned>(level) << (bit - 1);
            else {
                receiving_ = false;
                heard(static_cast<std::uint8_t>(value_), !level, start_);
            }
        }
    }
    bool receiving() const { return receiving_; }
    /// When a byte that it is receiving is whole.
    TimePoint whole_at(std::uint32_t bit_rate) const
    {
        return receiving_ ? start_ + bit_time(bits_per_byte, bit_rate) : TimePoint::max();
    }

private:
    static constexpr int stop_bit = 9;

    bool receiving_ = false;
    bool level_ = true; ///< an idle line is high
    int next_ = 0;      ///< bit that is sampled next
    unsigned value_ = 0;
    TimePoint start_{};
};

} // namespace sinew::sim
