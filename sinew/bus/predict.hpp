#pragma once
#include "sinew/wire/request.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

/// What the wire allows, from rows alone: how long frames, exchanges and cycles take, and how late a stop can be. Pure
/// functions; the conversation waits by the same figures. Of the host's own time nothing is in them.
namespace sinew::bus {

/// A wire as far as time is concerned. Bit rate 0: not known (TCP); then all times on the wire are 0.
struct Line {
    bool can = false;
    std::uint32_t bit_rate = 0;
};

/// CAN puts a stuff bit behind five equal ones, so the length of a frame depends on what it carries.
enum class Stuffing : std::uint8_t { least, most };

/// Bits of one frame with so many bytes, to the point where the next one may start. Serial: start, 8 data, stop. CAN:
/// base format, 44 bits + 8 for each byte + stuff bits + 3 between frames. Source: ISO 11898-1.
constexpr std::int64_t frame_bits(bool can, std::size_t bytes, Stuffing stuffing = Stuffing::most)
{
    const auto data = static_cast<std::int64_t>(8 * bytes);
    if (!can)
        return data + 2 * static_cast<std::int64_t>(bytes);
    return 44 + data + (stuffing == Stuffing::most ? (33 + data) / 4 : 0) + 3;
}

constexpr Duration frame_time(const Line& line, std::size_t bytes, Stuffing stuffing = Stuffing::most)
{
    return line.bit_rate == 0 ? Duration{} : bit_time(frame_bits(line.can, bytes, stuffing), line.bit_rate);
}

/// One request and what it brings.
struct Exchange {
    Duration request{};  ///< its bits
    Duration response{}; ///< what the device may take before it answers
    Duration replies{};  ///< their bits, of all devices that answer
    constexpr Duration wire() const { return request + replies; }
    constexpr Duration total() const { return request + response + replies; }
};

/// How many devices may answer a request: RMD's multi-motor frame up to four, unless the request knows better.
constexpr int reply_count(const wire::Request& request)
{
    if (!request.answered)
        return 0;
    if (request.replies != 0)
        return request.replies;
    return request.message->request.layout->can_fixed ? 4 : 1;
}

/// `time_of(bytes)`: how long a frame of so many bytes takes.
template <class TimeOf>
constexpr Exchange predict_by(const TimeOf& time_of, const wire::Request& request)
{
    const int replies = reply_count(request);
    return {.request = time_of(request.frame.size),
            .response = replies > 0 ? request.response_time : Duration{},
            .replies = replies > 0 ? replies * time_of(request.message->reply.size) : Duration{}};
}

constexpr Exchange predict(const Line& line, const wire::Request& request, Stuffing stuffing = Stuffing::most)
{
    return predict_by([&](std::size_t bytes) { return frame_time(line, bytes, stuffing); }, request);
}

/// The same for one line again and again: frames of each size are worked out once.
class Timetable
{
public:
    explicit Timetable(const Line& line)
    {
        for (std::size_t bytes = 0; bytes < time_of_.size(); ++bytes)
            time_of_[bytes] = frame_time(line, bytes);
    }
    /// Of a request that one device answers.
    Exchange predict_single(const wire::Request& request) const
    {
        return {.request = time_of_[request.frame.size],
                .response = request.response_time,
                .replies = time_of_[request.message->reply.size]};
    }
    Exchange predict(const wire::Request& request) const
    {
        return predict_by([&](std::size_t bytes) { return time_of_[bytes]; }, request);
    }

private:
    std::array<Duration, wire::Frame::capacity + 1> time_of_{};
};

/// The time in which the wire carries all requests once: one after the other on serial lines; on CAN back to back, one
/// outstanding per identifier, the lowest identifier first, so that response times count only where nobody else has
/// anything to send. Asks the heap.
Duration predict_cycle(const Line& line, std::span<const wire::Request> requests, Stuffing stuffing = Stuffing::most);

/// Bits of a request and of each of its replies, as `frame_bits` counts them.
struct ExchangeBits {
    std::int64_t request = 0;
    std::int64_t reply = 0;
};
/// The same where the lengths of the frames are known: those that were seen.
Duration predict_cycle(const Line& line, std::span<const wire::Request> requests, std::span<const ExchangeBits> bits);

/// How late a stop is at worst, counted from the moment at which it was asked for.
struct StopBound {
    Duration begins{}; ///< the first stop frame starts on the wire
    Duration first{};  ///< it has ended: where the family has a broadcast, every device knows
    Duration ends{};   ///< all stop frames and what they bring have ended
};

/// `running` is the exchange that the stop interrupts, `stop` what goes out then, in this order. Serial lines finish
/// the request in progress and leave its answer the time it has on the wire, because the answer would garble the stop.
/// So does CAN with all that is outstanding, one request of each identifier: where request and answer share an
/// identifier (RMD), two that start in one instant destroy each other.
StopBound predict_stop(const Line& line, std::span<const wire::Request> running, std::span<const wire::Request> stop);

} // namespace sinew::bus
