#include "sinew/bus/conversation.hpp"

#include <algorithm>

/// CAN: all requests at once, one outstanding per identifier, answers in any order.
namespace sinew::bus {

Conversation::Next Conversation::next_can(TimePoint now)
{
    if (stop_due_) [[unlikely]] {
        const TimePoint clear = last_due();
        if (now < clear)
            return {.deadline = clear};
        cut_in(now);
    }
    TimePoint deadline = TimePoint::max();
    if (sent_count_ > 0)
        for (std::size_t i = 0; i < requests_.size(); ++i) {
            Result& result = results_[i];
            if (result.stage != Result::Stage::sent)
                continue;
            if (now >= result.deadline) {
                release(requests_[i]);
                requests_[i].answered ? time_out(requests_[i], result, now) : finish(requests_[i], result, now);
            } else {
                deadline = std::min(deadline, result.deadline);
            }
        }
    if (waiting_count_ > 0)
        gather(now);
    return {.transmit = std::span(outbox_).first(outbox_size_), .deadline = deadline, .done = open_ == 0};
}

/// When all that is outstanding has had its time on the wire.
TimePoint Conversation::last_due() const
{
    TimePoint last{};
    for (const Result& result : results_)
        if (sent_count_ > 0 && result.stage == Result::Stage::sent)
            last = std::max(last, result.due);
    return last;
}

/// It is outstanding no more.
void Conversation::release(const wire::Request& request)
{
    outstanding_.reset(request.frame.can_id % outstanding_.size());
    --sent_count_;
    on_wire_ = sent_count_ == 0 ? Duration{} : on_wire_ - predict(line_, request).wire();
}

/// Puts into the outbox what may go out. Requests that share an identifier go out in the order in which they stand; one
/// for several devices goes out alone, because they answer it like requests of their own.
void Conversation::gather(TimePoint now)
{
    outbox_size_ = 0;
    auto taken = outstanding_;
    std::size_t before = sent_count_;
    for (std::size_t i = 0; i < requests_.size() && outbox_size_ < outbox_.size(); ++i) {
        const wire::Request& request = requests_[i];
        const bool waits = results_[i].stage == Result::Stage::waiting;
        const bool alone = request.message->request.layout->can_fixed;
        if (alone && results_[i].stage != Result::Stage::done && (!waits || before > 0))
            return;
        if (!waits)
            continue;
        const std::size_t identifier = request.frame.can_id % taken.size();
        if (taken.test(identifier))
            continue;
        taken.set(identifier);
        results_[i].sent_at = now;
        outbox_[outbox_size_] = request.frame;
        outbox_of_[outbox_size_++] = static_cast<std::uint16_t>(i);
        ++before;
        if (alone)
            return;
    }
}

void Conversation::received(const wire::Frame& frame, TimePoint at)
{
    const std::size_t size = sent_count_ > 0 ? requests_.size() : 0;
    std::size_t i = likely_ < size ? likely_ : 0;
    for (std::size_t left = size; left > 0; --left, i = i + 1 < size ? i + 1 : 0) {
        if (!accept(requests_[i], results_[i], frame, at))
            continue;
        if (results_[i].stage == Result::Stage::done)
            release(requests_[i]);
        likely_ = i + 1;
        return;
    }
    discard(frame, at);
}

} // namespace sinew::bus
