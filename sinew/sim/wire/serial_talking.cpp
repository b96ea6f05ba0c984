#include "sinew/sim/wire/serial_wire.hpp"

#include <algorithm>
#include <tuple>

namespace sinew::sim {

/// What becomes of a byte: nothing, one or two of them.
std::size_t SerialWire::spoil(std::uint8_t byte, const WireFaults* station, std::span<std::uint8_t, 2> out)
{
    bool is_dropped = false, is_followed = false;
    for (const WireFaults* faults : {static_cast<const WireFaults*>(&faults_), station}) {
        if (faults == nullptr)
            continue;
        if (dice_.falls(faults->flip_bit))
            byte = static_cast<std::uint8_t>(byte ^ 1U << dice_.pick(8));
        is_dropped |= dice_.falls(faults->drop_byte);
        is_followed |= dice_.falls(faults->add_byte);
    }
    std::size_t size = 0;
    if (!is_dropped)
        out[size++] = byte;
    if (is_followed)
        out[size++] = static_cast<std::uint8_t>(dice_.pick(256));
    return size;
}

const WireFaults* SerialWire::faults_of(Number station) const
{
    return station < station_faults_.size() ? &station_faults_[station] : nullptr;
}

std::size_t SerialWire::host_sends(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate, TimePoint now)
{
    if (bit_rate == 0)
        return bytes.size();
    if (!faults_.hits_bytes())
        return host_out_.send(bytes, bit_rate, now);
    std::size_t taken = 0;
    std::array<std::uint8_t, 2> sent{};
    for (; taken < bytes.size() && host_out_.room() > 0; ++taken) {
        const std::size_t size = spoil(bytes[taken], nullptr, sent);
        host_out_.send(std::span(sent).first(size), bit_rate, now);
    }
    return taken;
}

/// The heap is led by what is least for `std::less`, so later is less; ties go by the order of attachment.
static constexpr auto later = [](const auto& a, const auto& b) {
    return std::tie(a.next, a.station, a.start) > std::tie(b.next, b.station, b.start);
};

void SerialWire::reply(Number station, const Answer& answer, std::uint32_t bit_rate, TimePoint at)
{
    if (replies_.size() == stations_.size() + spare_replies)
        return;
    const WireFaults* own = faults_of(station);
    Duration delay = answer.delay;
    for (const WireFaults* faults : {static_cast<const WireFaults*>(&faults_), own})
        if (faults != nullptr && dice_.falls(faults->delay_reply))
            delay += faults->reply_delay;
    Talk& talk = talks_[station];
    Reply out{.station = station, .bit_rate = bit_rate};
    out.start = out.next = std::max(at + delay, talk.until);
    if (!faults_.hits_bytes() && (own == nullptr || !own->hits_bytes())) {
        std::ranges::copy(answer.frame.bytes(), out.bytes.begin());
        out.size = answer.frame.size;
    } else {
        std::array<std::uint8_t, 2> sent{};
        for (const std::uint8_t byte : answer.frame.bytes())
            for (std::size_t i = 0, size = spoil(byte, own, sent); i < size; ++i)
                out.bytes[out.size++] = sent[i];
    }
    if (talk.until <= at)
        talk.from = out.start;
    talk.until = out.start + bit_time(bits_per_byte * out.size, bit_rate);
    replies_.push_back(out);
    std::ranges::push_heap(replies_, later);
}

void SerialWire::start(Line& line, const Byte& byte)
{
    if (!line.talking.empty()) {
        if (!line.collides)
            begin_collision(line);
        hear_levels(line, byte.start);
    }
    line.talking.push_back(byte);
}

void SerialWire::start_host()
{
    const Transmitter::Byte byte = host_out_.start();
    start(from_host(), {.value = byte.value, .bit_rate = byte.bit_rate, .start = byte.start, .end = byte.end});
}

void SerialWire::start_reply()
{
    std::ranges::pop_heap(replies_, later);
    Reply& out = replies_.back();
    if (out.size == 0) { // each of its bytes was lost
        const Reply lost = out;
        replies_.pop_back();
        answered(lost.station, lost.next);
        return;
    }
    const Byte byte{.value = out.bytes[out.sent],
                    .is_last = out.sent + 1 == out.size,
                    .bit_rate = out.bit_rate,
                    .talker = out.station,
                    .start = out.next,
                    .end = out.start + bit_time(bits_per_byte * (out.sent + 1), out.bit_rate)};
    out.next = byte.end;
    ++out.sent;
    if (byte.is_last)
        replies_.pop_back();
    else
        std::ranges::push_heap(replies_, later);
    start(from_stations(), byte);
}

void SerialWire::finish(Line& line, TimePoint at)
{
    while (!line.talking.empty()) {
        const auto first = std::ranges::min_element(line.talking, {}, &Byte::end);
        const Byte byte = *first;
        if (byte.end > at)
            return;
        if (line.collides)
            hear_levels(line, byte.end);
        else
            hear_alone(line, byte);
        if (line.talking.size() == 1)
            line.talking.clear();
        else
            line.talking.erase(first);
        line.collides &= !line.talking.empty();
        if (byte.is_last)
            answered(byte.talker, byte.end);
    }
}

void SerialWire::answered(Number station, TimePoint at)
{
    stations_[station].station->answered(at);
    has_changed_ |= stations_.has_changed(station);
}

} // namespace sinew::sim
