#include "sinew/sim/wire/serial_wire.hpp"

#include <algorithm>

namespace sinew::sim {
namespace {

Duration longest_pause(std::uint32_t bit_rate)
{
    return std::max<Duration>(std::chrono::milliseconds{5}, bit_time(20 * bits_per_byte, bit_rate));
}

} // namespace

void SerialWire::rebuild()
{
    has_changed_ = false;
    stations_.refresh();
    for (Ear& ear : ears_)
        ear.is_used = false;
    for (Number number = 0; number < stations_.size(); ++number) {
        const Directory::Entry& entry = stations_[number];
        if (entry.bit_rate == 0)
            continue;
        const wire::Protocol* protocol = &entry.station->protocol();
        const auto same = std::ranges::find_if(
            ears_, [&](const Ear& ear) { return ear.bit_rate == entry.bit_rate && ear.protocol == protocol; });
        if (same != ears_.end())
            same->is_used = true;
        else if (ears_.size() < most_ears)
            ears_.push_back(
                {.bit_rate = entry.bit_rate, .protocol = protocol, .patience = longest_pause(entry.bit_rate)});
    }
    std::erase_if(ears_, [](const Ear& ear) { return !ear.is_used; });
}

/// Calls `call(sampler, bit_rate, heard, is_host)` for everybody who hears this line.
template <class F>
void SerialWire::for_each_listener(const Line& line, TimePoint at, F&& call)
{
    if (&line == &from_host())
        for (Ear& ear : ears_)
            call(
                ear.sampler, ear.bit_rate,
                [&](std::uint8_t value, bool broken, TimePoint start) {
                    if (!broken || passes_broken_)
                        hear(ear, value, start, at);
                },
                false);
    if (&line == &from_stations() && host_rate() != 0)
        call(
            host_in_, host_rate(),
            [&](std::uint8_t value, bool broken, TimePoint) {
                if (!broken || passes_broken_)
                    host_hears(value, at);
            },
            true);
}

void SerialWire::begin_collision(Line& line)
{
    line.collides = samples_ = true;
    line.heard_to = line.talking.front().start;
    for_each_listener(line, line.heard_to, [&](Sampler& sampler, std::uint32_t bit_rate, auto&& heard, bool) {
        sampler.feed(true, line.heard_to, line.heard_to, bit_rate, heard);
    });
}

void SerialWire::hear_levels(Line& line, TimePoint until)
{
    while (line.heard_to < until) {
        const TimePoint from = line.heard_to;
        TimePoint to = until;
        bool is_high = false, is_low = false, host_talks = false;
        for (const Byte& byte : line.talking) {
            int bit = static_cast<int>((from - byte.start).count() * byte.bit_rate / 1'000'000'000);
            while (bit < 9 && byte.edge(bit + 1) <= from)
                ++bit;
            to = std::min(to, byte.edge(bit + 1));
            (byte.level(bit) ? is_high : is_low) = true;
            host_talks |= byte.talker == the_host;
        }
        const bool is_fought = is_high && is_low;
        const bool level = is_fought && contention_ == Contention::garble ? dice_.pick(2) != 0 : !is_low;
        for_each_listener(line, to, [&](Sampler& sampler, std::uint32_t bit_rate, auto&& heard, bool is_host) {
            const bool is_deaf = is_host && host_talks && !host_end_.echo;
            sampler.feed(level || is_deaf, from, to, bit_rate, heard);
        });
        line.heard_to = to;
    }
}

void SerialWire::hear_alone(const Line& line, const Byte& byte)
{
    const bool is_echo = byte.talker == the_host;
    for_each_listener(line, byte.end, [&](Sampler& sampler, std::uint32_t bit_rate, auto&& heard, bool is_host) {
        if (is_host && is_echo && !host_end_.echo)
            return;
        sampler.feed(true, byte.start, byte.start, bit_rate, heard);
        if (bit_rate == byte.bit_rate && !sampler.receiving()) {
            heard(byte.value, false, byte.start);
            return;
        }
        samples_ = true;
        for (int bit = 0; bit < bits_per_byte; ++bit)
            sampler.feed(byte.level(bit), byte.edge(bit), byte.edge(bit + 1), bit_rate, heard);
    });
    if (duplex_ == Duplex::full && is_echo && host_end_.echo && host_rate() == byte.bit_rate)
        host_hears(byte.value, byte.end);
}

/// What only shows while nobody talks.
void SerialWire::hear_silence(TimePoint at)
{
    if (samples_) {
        for (const Line& line : lines_)
            if (line.talking.empty())
                for_each_listener(line, at, [&](Sampler& sampler, std::uint32_t bit_rate, auto&& heard, bool) {
                    if (sampler.whole_at(bit_rate) <= at)
                        sampler.feed(true, at, at, bit_rate, heard);
                });
        samples_ = lines_[0].collides || lines_[1].collides || host_in_.receiving() ||
                   std::ranges::any_of(ears_, [](const Ear& ear) { return ear.sampler.receiving(); });
    }
    for (Ear& ear : ears_)
        if (ear.gives_up <= at)
            find_requests(ear, true, at);
}

void SerialWire::hear(Ear& ear, std::uint8_t value, TimePoint start, TimePoint at)
{
    ear.in.add(value, start);
    ear.gives_up = at + ear.patience;
    find_requests(ear, false, at);
}

void SerialWire::find_requests(Ear& ear, bool silent, TimePoint at)
{
    while (!ear.in.empty()) {
        const auto bytes = ear.in.bytes();
        const wire::Scan scan = ear.protocol->find_request(bytes, silent);
        if (scan.size == 0 || scan.size > wire::Frame::capacity) {
            ear.in.drop(scan.skip + scan.size);
            if (scan.size == 0)
                break;
            continue;
        }
        wire::Frame request{.size = static_cast<std::uint8_t>(scan.size)};
        std::ranges::copy(bytes.subspan(scan.skip, scan.size), request.data.begin());
        const TimePoint start = ear.in.start(scan.skip);
        ear.in.drop(scan.skip + scan.size);
        pass(ear, request, start, at);
    }
    if (silent)
        ear.in.drop(ear.in.bytes().size());
    if (ear.in.empty())
        ear.gives_up = TimePoint::max();
}

void SerialWire::pass(const Ear& ear, const wire::Frame& request, TimePoint start, TimePoint at)
{
    stations_.for_each(ear.protocol->addressee(request), [&](Number number) {
        Station& station = *stations_[number].station;
        const Talk& talk = talks_[number];
        const bool talked = duplex_ == Duplex::half && talk.from < at && start < talk.until;
        if (stations_[number].bit_rate != ear.bit_rate || &station.protocol() != ear.protocol || talked)
            return;
        // A device may have lost its power since. A message that changes the rate is still answered at the old one.
        if (station.bit_rate() == ear.bit_rate)
            if (const auto answer = station.hear(request, at))
                reply(number, *answer, ear.bit_rate, at);
        has_changed_ |= stations_.has_changed(number);
    });
}

void SerialWire::host_hears(std::uint8_t value, TimePoint at)
{
    if (host_end_.usb_latency <= Duration{}) {
        host_->on_bytes({&value, 1}, at);
        return;
    }
    if (batch_size_ == 0)
        batch_due_ = at + host_end_.usb_latency;
    batch_[batch_size_++] = value;
    if (batch_size_ == batch_.size())
        hand_over(at);
}

void SerialWire::hand_over(TimePoint at)
{
    const std::size_t size = batch_size_;
    batch_size_ = 0;
    batch_due_ = TimePoint::max();
    if (host_ != nullptr && size != 0)
        host_->on_bytes(std::span(batch_).first(size), at);
}

} // namespace sinew::sim
