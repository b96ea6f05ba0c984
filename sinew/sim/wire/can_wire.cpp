#include "sinew/sim/wire/can_wire.hpp"

#include <algorithm>

namespace sinew::sim {
namespace {

/// Bits as they leave a CAN controller: counted with the stuff bits, and taken into the CRC without them.
class BitCounter
{
public:
    void add(std::uint32_t value, int width)
    {
        for (int bit = width - 1; bit >= 0; --bit)
            add((value >> bit & 1U) != 0);
    }
    std::uint32_t crc() const { return crc_; }
    int count() const { return count_; }

private:
    void add(bool bit)
    {
        ++count_;
        run_ = bit == last_ ? run_ + 1 : 1;
        last_ = bit;
        if (run_ == 5) { // the stuff bit is the opposite and begins a run of its own
            ++count_;
            run_ = 1;
            last_ = !bit;
        }
        const bool feedback = bit != ((crc_ >> 14 & 1U) != 0);
        crc_ = crc_ << 1 & 0x7FFF;
        if (feedback)
            crc_ ^= 0x4599;
    }

    int count_ = 0;
    int run_ = 0;
    bool last_ = true; // the idle bus is recessive
    std::uint32_t crc_ = 0;
};

/// Bit of a frame from its start bit on, without stuff bits, up to the end of its data.
bool bit_of(const wire::Frame& frame, int place)
{
    constexpr int header_bits = 19;
    if (place < header_bits)
        return ((frame.can_id << 7 | frame.size) >> (header_bits - 1 - place) & 1U) != 0;
    const int data_bit = place - header_bits;
    return (frame.data[static_cast<std::size_t>(data_bit / 8)] >> (7 - data_bit % 8) & 1U) != 0;
}

/// Bits on the wire up to and with the first one in which two frames differ.
int bits_in_common(const wire::Frame& a, const wire::Frame& b)
{
    BitCounter bits;
    int place = 0;
    for (; bit_of(a, place) == bit_of(b, place); ++place)
        bits.add(bit_of(a, place) ? 1 : 0, 1);
    return bits.count() + 1;
}

/// An error flag of six bits, up to six more of those who see only by the flag that something is wrong, and the
/// delimiter. With the space that follows 17 to 23 bits. Source: ISO 11898-1.
constexpr int error_frame_bits = 14, more_flag_bits = 6;

} // namespace

int can_frame_bits(const wire::Frame& frame)
{
    constexpr int crc_delimiter = 1, acknowledge = 2, end_of_frame = 7;
    BitCounter bits;
    bits.add(0, 1); // start of frame
    bits.add(frame.can_id, 11);
    bits.add(0, 3); // data frame, base format, reserved
    bits.add(frame.size, 4);
    for (const std::uint8_t byte : frame.bytes())
        bits.add(byte, 8);
    bits.add(bits.crc(), 15);
    return bits.count() + crc_delimiter + acknowledge + end_of_frame;
}

void CanWire::attach(Station& station)
{
    stations_.add(station);
    turns_.emplace_back();
    if (!station_faults_.empty())
        station_faults_.emplace_back();
    replies_.reserve(stations_.size() + spare_replies);
}

void CanWire::set_faults(const Station& station, const WireFaults& faults)
{
    station_faults_.resize(stations_.size());
    const Number number = stations_.number_of(station);
    if (number < stations_.size())
        station_faults_[number] = faults;
}

bool CanWire::host_sends(const wire::Frame& frame, std::uint32_t bit_rate, TimePoint now)
{
    if (bit_rate == 0 || frame.size > 8)
        return true;
    return host_out_.push({.frame = frame, .bit_rate = bit_rate, .from = now});
}

void CanWire::reply(Number station, const Answer& answer, std::uint32_t bit_rate, TimePoint at)
{
    if (replies_.size() == stations_.size() + spare_replies)
        return;
    Duration delay = answer.delay;
    if (dice_.falls(faults_.delay_reply))
        delay += faults_.reply_delay;
    if (station < station_faults_.size() && dice_.falls(station_faults_[station].delay_reply))
        delay += station_faults_[station].reply_delay;
    replies_.push_back({answer.frame, bit_rate, at + delay, station, turns_[station].given++});
}

TimePoint CanWire::next_event() const
{
    if (busy_)
        return ends_;
    TimePoint first = host_out_.empty() ? TimePoint::max() : std::max(host_out_.front().from, idle_);
    for (const Ready& reply : replies_)
        if (is_ready(reply, reply.from))
            first = std::min(first, std::max(reply.from, idle_));
    return first;
}

void CanWire::run_until(TimePoint until)
{
    for (TimePoint at = next_event(); at <= until && at != TimePoint::max(); at = next_event()) {
        if (busy_)
            finish();
        else
            start(at);
    }
}

template <class F>
void CanWire::for_each_ready(TimePoint at, F&& call) const
{
    if (!host_out_.empty() && host_out_.front().from <= at)
        call(host_out_.front());
    for (const Ready& reply : replies_)
        if (is_ready(reply, at))
            call(reply);
}

/// Whether this happens to the frame on the wire.
bool CanWire::falls(double WireFaults::* fault)
{
    const bool by_wire = dice_.falls(faults_.*fault);
    const bool by_station =
        on_wire_.talker < station_faults_.size() && dice_.falls(station_faults_[on_wire_.talker].*fault);
    return by_wire || by_station;
}

/// 0: nobody who begins now has other data under the identifier that wins.
int CanWire::bits_until_bit_error(TimePoint at) const
{
    int bits = 0;
    for_each_ready(at, [&](const Ready& ready) {
        if (ready.frame.can_id != on_wire_.frame.can_id || ready.frame == on_wire_.frame)
            return;
        const int common = bits_in_common(ready.frame, on_wire_.frame);
        bits = bits == 0 ? common : std::min(bits, common);
    });
    return bits;
}

void CanWire::start(TimePoint at)
{
    const std::uint32_t before = on_wire_.frame.can_id;
    const Ready* winner = nullptr;
    for_each_ready(at, [&](const Ready& ready) {
        if (winner == nullptr || ready.frame.can_id < winner->frame.can_id)
            winner = &ready;
    });
    on_wire_ = *winner;
    if (on_wire_.frame.can_id != before)
        tries_ = 0;
    int bits = can_frame_bits(on_wire_.frame);
    const int fought = bits_until_bit_error(at);
    outcome_ = Outcome::heard;
    if (fought != 0) {
        outcome_ = Outcome::destroyed;
        // Who sent the recessive bit sees the error at once, the others by the stuffing that its flag breaks.
        bits = fought + error_frame_bits + more_flag_bits;
    } else if (falls(&WireFaults::flip_bit)) {
        outcome_ = Outcome::destroyed;
        bits = 1 + static_cast<int>(dice_.pick(static_cast<unsigned>(bits)) + dice_.pick(more_flag_bits + 1)) +
               error_frame_bits;
    } else if (falls(&WireFaults::drop_byte)) {
        outcome_ = Outcome::lost;
    } else if (falls(&WireFaults::add_byte)) {
        outcome_ = Outcome::repeated;
    }
    busy_ = true;
    started_ = at;
    ends_ = at + bit_time(bits, on_wire_.bit_rate);
    idle_ = at + bit_time(bits + can_interframe_bits, on_wire_.bit_rate);
}

void CanWire::finish()
{
    busy_ = false;
    const Ready heard = on_wire_;
    const TimePoint at = ends_;
    if (outcome_ == Outcome::destroyed) {
        ++counters_.error_frames;
        if (++tries_ == most_tries) {
            tries_ = 0;
            remove(at, true);
        }
        return;
    }
    tries_ = 0;
    if (outcome_ != Outcome::copy)
        remove(at, false);
    if (outcome_ == Outcome::repeated) {
        const int bits = can_frame_bits(heard.frame);
        outcome_ = Outcome::copy;
        busy_ = true;
        ends_ = idle_ + bit_time(bits, heard.bit_rate);
        idle_ += bit_time(bits + can_interframe_bits, heard.bit_rate);
    } else if (outcome_ == Outcome::lost) {
        return;
    }
    pass(heard, at);
}

/// Takes out of the queues what was sent: the frame on the wire and all that are alike; or, given up, all that fought
/// for its identifier.
void CanWire::remove(TimePoint at, bool is_given_up)
{
    const auto is_sent = [&](const Ready& ready) {
        return ready.from <= started_ && ready.frame.can_id == on_wire_.frame.can_id &&
               (is_given_up || ready.frame == on_wire_.frame);
    };
    if (!host_out_.empty() && is_sent(host_out_.front())) {
        host_out_.pop();
        counters_.given_up += is_given_up ? 1 : 0;
    }
    bool has_changed = false;
    for (std::size_t i = replies_.size(); i-- > 0;) { // from the back: the next of a station is not ready yet
        const Ready reply = replies_[i];
        if (!is_ready(reply, started_) || !is_sent(reply))
            continue;
        replies_.erase(replies_.begin() + static_cast<std::ptrdiff_t>(i));
        ++turns_[reply.talker].served;
        counters_.given_up += is_given_up ? 1 : 0;
        stations_[reply.talker].station->answered(at);
        has_changed |= stations_.has_changed(reply.talker);
    }
    if (has_changed)
        stations_.refresh();
}

void CanWire::pass(const Ready& heard, TimePoint at)
{
    if (heard.talker != the_host) {
        if (host_ != nullptr && host_->bit_rate() == heard.bit_rate)
            host_->on_frame(heard.frame, at);
        return;
    }
    if (stations_.size() == 0)
        return;
    bool has_changed = false;
    stations_.for_each(stations_[0].station->protocol().addressee(heard.frame), [&](Number number) {
        Station& station = *stations_[number].station;
        // A message that changes the rate is still answered at the old one.
        if (station.bit_rate() == heard.bit_rate)
            if (const auto answer = station.hear(heard.frame, at))
                reply(number, *answer, heard.bit_rate, at);
        has_changed |= stations_.has_changed(number);
    });
    if (has_changed)
        stations_.refresh();
}

} // namespace sinew::sim
