#include "sinew/record/answers.hpp"

#include <algorithm>

namespace sinew::record {
namespace {

// More requests than a batch holds are never under way at once.
constexpr std::size_t most_open = 256;

/// How well a reply on CAN fits a request; 0: not at all. The first byte is the command in every message of the family.
int fit(const Captured& reply, std::uint32_t can_id, std::span<const std::uint8_t> asked)
{
    constexpr std::uint32_t device_bits = 0xFF; // another base for replies keeps the number of the device
    if (asked.empty() || reply.frame.size == 0 || asked[0] != reply.frame.data[0])
        return 0;
    if (reply.frame.can_id == can_id)
        return 3;
    return (reply.frame.can_id & device_bits) == (can_id & device_bits) ? 2 : 1;
}

} // namespace

Answers::Open* Answers::asked_by(const Captured& reply)
{
    if (!can_)
        return open_.empty() ? nullptr : &open_.back();
    Open* best = nullptr;
    int how_well = 0;
    for (auto& open : open_) {
        // A request for several devices has several answers, so having one does not rule it out.
        const int fits = 2 * fit(reply, open.key.first, open.key.second) - (open.answered ? 1 : 0);
        if (fits > how_well) {
            best = &open;
            how_well = fits;
        }
    }
    return best;
}

void Answers::begin(const Captured& request)
{
    const auto data = request.data();
    Key key{request.frame.can_id, {data.begin(), data.end()}};
    auto& times = requests_[key].times;
    times.emplace_back();
    open_.push_back({std::move(key), times.size() - 1, request.at});
    if (open_.size() > most_open)
        open_.pop_front();
}

void Answers::add(const Captured& captured)
{
    can_ = captured.is_can();
    if (captured.kind == Captured::Kind::can_error || captured.kind == Captured::Kind::can_remote ||
        captured.discarded == "echo" || (!captured.direction && !can_))
        return;
    auto direction = captured.direction;
    Open* asked = direction == wire::Direction::request ? nullptr : asked_by(captured);
    if (!direction) {
        const bool answers = asked != nullptr && !asked->answered && asked->key.first == captured.frame.can_id &&
                             captured.at - asked->at <= answer_most;
        direction = answers ? wire::Direction::reply : wire::Direction::request;
    }
    if (direction == wire::Direction::request) {
        begin(captured);
        return;
    }
    if (asked == nullptr)
        return;
    asked->answered = true;
    requests_[asked->key].times[asked->time].push_back({captured.at - asked->at, captured});
}

std::span<const Answers::Reply> Answers::next(std::uint32_t can_id, std::span<const std::uint8_t> bytes, bool loop)
{
    const auto found = requests_.find(Key{can_id, {bytes.begin(), bytes.end()}});
    if (found == requests_.end())
        return {};
    auto& [times, given] = found->second;
    if (given == times.size() && loop)
        given = 0;
    if (given < times.size()) {
        ++given_;
        return times[given++];
    }
    return times.size() == 1 ? std::span<const Reply>(times.front()) : std::span<const Reply>{};
}

void Answers::rewind()
{
    for (auto& [key, request] : requests_)
        request.given = 0;
}

} // namespace sinew::record
