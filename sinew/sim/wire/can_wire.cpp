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
    nodes_.push_back({.station = &station, .queue = Ring<Ready>(station_capacity)});
}

bool CanWire::host_sends(const wire::Frame& frame, std::uint32_t bit_rate, TimePoint now)
{
    if (bit_rate == 0 || frame.size > 8)
        return true;
    return nodes_[0].queue.push({frame, bit_rate, now});
}

TimePoint CanWire::next_event() const
{
    if (busy_)
        return ends_;
    TimePoint first = TimePoint::max();
    for (const Node& node : nodes_)
        if (!node.queue.empty())
            first = std::min(first, std::max(node.queue.front().from, idle_));
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

void CanWire::start(TimePoint at)
{
    Node* winner = nullptr;
    for (Node& node : nodes_) {
        if (node.queue.empty() || node.queue.front().from > at)
            continue;
        if (winner == nullptr || node.queue.front().frame.can_id < winner->queue.front().frame.can_id)
            winner = &node;
    }
    on_wire_ = winner->queue.front();
    talker_ = winner->station;
    winner->queue.pop();
    const int bits = can_frame_bits(on_wire_.frame);
    busy_ = true;
    ends_ = at + bit_time(bits, on_wire_.bit_rate);
    idle_ = at + bit_time(bits + can_interframe_bits, on_wire_.bit_rate);
}

void CanWire::finish()
{
    busy_ = false;
    const Ready heard = on_wire_;
    const TimePoint at = ends_;
    if (talker_ != nullptr) {
        talker_->answered(at);
        if (host_ != nullptr && host_->bit_rate() == heard.bit_rate)
            host_->on_frame(heard.frame, at);
        return;
    }
    for (Node& node : nodes_) {
        if (node.station == nullptr)
            continue;
        if (node.station->bit_rate() != heard.bit_rate)
            continue;
        // A message that changes the rate is still answered at the old one.
        if (const auto answer = node.station->hear(heard.frame, at))
            node.queue.push({answer->frame, heard.bit_rate, at + answer->delay});
    }
}

} // namespace sinew::sim
