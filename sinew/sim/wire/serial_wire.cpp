#include "sinew/sim/wire/serial_wire.hpp"

#include <algorithm>

namespace sinew::sim {

void SerialWire::attach(Station& station)
{
    stations_.add(station);
    talks_.emplace_back();
    if (!station_faults_.empty())
        station_faults_.emplace_back();
    replies_.reserve(stations_.size() + spare_replies);
    ears_.reserve(most_ears);
    from_host().talking.reserve(1);
    from_stations().talking.reserve(stations_.size() + 1);
    rebuild();
}

void SerialWire::connect(SerialHost* host)
{
    host_ = host;
    host_in_ = {};
    batch_size_ = 0;
    batch_due_ = TimePoint::max();
}

void SerialWire::refresh()
{
    if (stations_.has_changed())
        rebuild();
}

void SerialWire::set_faults(const Station& station, const WireFaults& faults)
{
    station_faults_.resize(stations_.size());
    const Number number = stations_.number_of(station);
    if (number < stations_.size())
        station_faults_[number] = faults;
}

TimePoint SerialWire::Line::next_event() const
{
    TimePoint next = TimePoint::max();
    for (const Byte& byte : talking)
        next = std::min(next, byte.end);
    return next;
}

TimePoint SerialWire::next_event() const
{
    TimePoint next = std::min({host_out_.next_start(), lines_[0].next_event(), lines_[1].next_event(), batch_due_});
    if (!replies_.empty())
        next = std::min(next, replies_.front().next);
    for (const Ear& ear : ears_)
        next = std::min(next, ear.gives_up);
    if (!samples_)
        return next;
    if (lines_[0].talking.empty())
        for (const Ear& ear : ears_)
            next = std::min(next, ear.sampler.whole_at(ear.bit_rate));
    if (from_stations().talking.empty() && host_rate() != 0)
        next = std::min(next, host_in_.whole_at(host_rate()));
    return next;
}

void SerialWire::run_until(TimePoint until)
{
    for (TimePoint at = next_event(); at <= until && at != TimePoint::max(); at = next_event())
        step(at);
}

void SerialWire::step(TimePoint at)
{
    // Ends before starts: bytes of one talker follow each other without a gap and must not be taken for a collision.
    for (Line& line : lines_)
        if (!line.talking.empty())
            finish(line, at);
    hear_silence(at);
    if (batch_due_ <= at)
        hand_over(at);
    if (host_out_.next_start() <= at)
        start_host();
    while (!replies_.empty() && replies_.front().next <= at)
        start_reply();
    if (has_changed_)
        rebuild();
}

} // namespace sinew::sim
