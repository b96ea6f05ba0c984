#pragma once
#include "sinew/bus/conversation.hpp"

#include <algorithm>

/// What every exchange that goes well passes through, inline: for the sources of this room only. Whatever is out of the
/// ordinary is a call.
namespace sinew::bus {

/// From here on its identifier is taken.
[[gnu::always_inline]] inline void Conversation::put_into_outbox(std::size_t i, TimePoint now)
{
    results_[i].sent_at = now;
    outstanding_.set(requests_[i].frame.can_id % outstanding_.size());
    outbox_of_[outbox_size_++] = static_cast<std::uint16_t>(i);
}

/// It is outstanding no more.
[[gnu::always_inline]] inline void Conversation::release(const wire::Request& request)
{
    outstanding_.reset(request.frame.can_id % outstanding_.size());
    --sent_count_;
    on_wire_ = sent_count_ == 0 ? Duration{} : on_wire_ - times_.predict(request).wire();
}

[[gnu::always_inline]] inline void Conversation::sent(const wire::Request& request, Result& result, TimePoint due,
                                                      TimePoint now)
{
    result.stage = Result::Stage::sent;
    ++result.tries;
    count(&Counters::requests, request.id);
    result.due = due;
    result.deadline = request.answered && !unusual_.urgent ? due + margin_ : due;
    tell(Verdict::sent, request.frame.bytes(), now, request.frame.can_id);
}

/// Before that nothing is an answer. Three quarters of the time, because clocks differ and a UART is done in the middle
/// of the stop bit. A byte that is part of a bare reply comes after the request; a whole frame takes its own time as
/// well.
[[gnu::always_inline]] inline TimePoint Conversation::earliest(Duration request, Duration replies,
                                                               TimePoint sent_at) const
{
    if (!settings_.paced)
        return sent_at;
    const Duration own = bare_ ? request : request + replies;
    return sent_at + own - Duration{own.count() >> 2};
}

[[gnu::always_inline]] inline void Conversation::transmitted_can(std::size_t count, TimePoint now)
{
    for (std::size_t i = 0; i < count; ++i)
        on_wire_ += times_.predict(requests_[outbox_of_[i]]).wire();
    const TimePoint clear = std::max(now, clear_at_) + on_wire_;
    if (sent_count_ == 0)
        first_expiry_ = TimePoint::max();
    for (std::size_t i = 0; i < count; ++i) {
        const wire::Request& request = requests_[outbox_of_[i]];
        Result& result = results_[outbox_of_[i]];
        sent(request, result, clear + times_.predict(request).response, now);
        first_expiry_ = std::min(first_expiry_, result.deadline);
    }
    sent_count_ += count;
    waiting_count_ -= count;
    if (count < outbox_size_) [[unlikely]]
        take_back(count);
    outbox_size_ = 0;
}

/// The margin follows the slowest recent answer: twice what the link added, forgetting slowly.
[[gnu::always_inline]] inline void Conversation::learn(Duration excess)
{
    const std::int64_t before = excess_.count();
    excess_ = Duration{std::max(excess.count(), before - (before >> 6))};
    if (measured_ < 8) [[unlikely]] {
        ++measured_;
        return;
    }
    const std::int64_t wanted = std::max((2 * excess_).count(), settings_.margin_least.count());
    margin_ = Duration{std::min(wanted, settings_.margin_most.count())};
}

/// What is read after its deadline was waited for no longer: it was there by then, and nobody looked. Where it says
/// what a device was like, that is at least so old.
[[gnu::always_inline]] inline void Conversation::arrived(Result& result, TimePoint read_at)
{
    result.at = read_at;
    if (read_at > result.deadline) [[unlikely]]
        result.at = result.deadline;
}

[[gnu::always_inline]] inline void Conversation::finish(const wire::Request& request, Result& result, TimePoint at)
{
    result.stage = Result::Stage::done;
    result.good = true;
    arrived(result, at);
    --open_;
    if (!request.answered) [[unlikely]]
        return finish_unanswered(request, at);
    note_answer(request, result, result.reply_count, per_id_[slot_of(request.id)], at);
}

/// What is learnt from an answer, or from so many frames of it.
[[gnu::always_inline]] inline void Conversation::note_answer(const wire::Request& request, Result& result,
                                                             unsigned frames, Counters& own, TimePoint at)
{
    const std::size_t bucket = Counters::bucket_of(at - result.sent_at);
    for (Counters* counters : {&total_, &own}) {
        counters->replies += frames;
        ++counters->round_trips[bucket];
    }
    if (lateness_.is_possible(at)) [[unlikely]] { // never where replies are bare
        result.possibly_older = lateness_.may_be_older(request, at, result.deadline + settings_.late_max);
        if (result.possibly_older)
            return;
    }
    learn(at - result.due);
}

[[gnu::always_inline]] inline bool Conversation::accept(const wire::Request& request, Result& result,
                                                        const wire::Frame& frame, TimePoint at)
{
    if (result.stage != Result::Stage::sent || !request.answered ||
        !protocol_.answers(request.frame, *request.message, frame, request.options))
        return false;
    if (request.message->request.layout->can_fixed) [[unlikely]]
        return accept_from_one(request, result, frame, at);
    tell(Verdict::taken, frame.bytes(), at, frame.can_id);
    result.replies[result.reply_count++] = frame;
    if (!settings_.double_read || is_confirmed(request, result, at)) [[likely]]
        finish(request, result, at);
    return true;
}

/// Whether the frame is the answer to request `i`.
[[gnu::always_inline]] inline bool Conversation::take(std::size_t i, const wire::Frame& frame, TimePoint at)
{
    if (i >= requests_.size() || !accept(requests_[i], results_[i], frame, at))
        return false;
    if (results_[i].stage == Result::Stage::done)
        release(requests_[i]);
    likely_ = i + 1;
    latest_of_[frame.can_id % latest_of_.size()] = static_cast<std::uint16_t>(i);
    return true;
}

template <bool IsCan>
[[gnu::always_inline]] inline void Conversation::sent_plain(const wire::Request& request, Result& result, Counters& own,
                                                            TimePoint now)
{
    result.reset();
    result.stage = Result::Stage::sent;
    result.tries = 1;
    result.sent_at = now;
    const Exchange exchange = times_.predict_single(request);
    result.due = (IsCan ? std::max(now, clear_at_) : now) + exchange.total();
    result.deadline = result.due + margin_;
    if constexpr (!IsCan)
        earliest_ = earliest(exchange.request, exchange.replies, now);
    ++total_.requests;
    ++own.requests;
}

[[gnu::always_inline]] inline bool Conversation::answered_plain(const wire::Request& request, Result& result,
                                                                Counters& own, std::span<const std::uint8_t> bytes,
                                                                TimePoint at)
{
    if (bytes.size() != request.message->reply.size || at < earliest_) [[unlikely]]
        return false;
    result.replies[0].assign(bytes);
    return answered_plain(request, result, own, at);
}

[[gnu::always_inline]] inline bool Conversation::answered_plain(const wire::Request& request, Result& result,
                                                                Counters& own, TimePoint at)
{
    if (!protocol_.is_answer(request.frame, *request.message, result.replies[0], request.options)) [[unlikely]]
        return false;
    result.stage = Result::Stage::done;
    result.reply_count = 1;
    result.good = true;
    arrived(result, at);
    note_answer(request, result, 1, own, at);
    return true;
}

} // namespace sinew::bus
