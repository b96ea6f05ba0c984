#include "sinew/bus/conversation_hot.hpp"

#include <algorithm>

/// CAN: all requests at once, one outstanding per identifier, answers in any order.
namespace sinew::bus {

Conversation::Next Conversation::next_can(TimePoint now)
{
    if (unusual_.stop_due) [[unlikely]] {
        const TimePoint clear = last_due();
        if (now < clear)
            return {.deadline = clear};
        cut_in(now);
    }
    if (sent_count_ > 0 && now >= first_expiry_)
        expire(now);
    const TimePoint deadline = sent_count_ > 0 ? first_expiry_ : TimePoint::max();
    if (waiting_count_ > 0)
        gather(now);
    return {.transmit = std::span(outbox_).first(outbox_size_), .deadline = deadline, .done = open_ == 0};
}

/// Ends what has had its time.
void Conversation::expire(TimePoint now)
{
    first_expiry_ = TimePoint::max();
    for (std::size_t i = 0; i < requests_.size(); ++i) {
        Result& result = results_[i];
        if (result.stage != Result::Stage::sent)
            continue;
        if (now >= result.deadline) {
            release(requests_[i]);
            requests_[i].answered ? time_out(requests_[i], result, now) : finish(requests_[i], result, now);
        } else {
            first_expiry_ = std::min(first_expiry_, result.deadline);
        }
    }
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

/// All but the first `kept` of its frames stay behind and are outstanding no more.
void Conversation::take_back(std::size_t kept)
{
    for (std::size_t i = kept; i < outbox_size_; ++i)
        outstanding_.reset(requests_[outbox_of_[i]].frame.can_id % outstanding_.size());
    outbox_size_ = 0;
}

/// Puts into the outbox what may go out. Requests that share an identifier go out in the order in which they stand; one
/// for several devices goes out alone, because they answer it like requests of their own.
void Conversation::gather(TimePoint now)
{
    take_back(0);
    for (std::size_t i = 0; i < requests_.size() && outbox_size_ < outbox_.size(); ++i) {
        const wire::Request& request = requests_[i];
        const bool waits = results_[i].stage == Result::Stage::waiting;
        const bool alone = request.message->request.layout->can_fixed;
        if (alone && results_[i].stage != Result::Stage::done && (!waits || sent_count_ + outbox_size_ > 0))
            return;
        if (!waits || outstanding_.test(request.frame.can_id % outstanding_.size()))
            continue;
        outbox_[outbox_size_] = request.frame;
        put_into_outbox(i, now);
        if (alone)
            return;
    }
}

/// Whose answer it can be is asked of all requests; first of those whose it most likely is.
void Conversation::received(const wire::Frame& frame, TimePoint at)
{
    if (sent_count_ > 0) {
        if (take(likely_, frame, at) || take(latest_of_[frame.can_id % latest_of_.size()], frame, at)) [[likely]]
            return;
        for (std::size_t i = 0; i < requests_.size(); ++i)
            if (take(i, frame, at))
                return;
    }
    discard(frame, at);
}

} // namespace sinew::bus
