#include "sinew/bus/conversation_hot.hpp"

#include <algorithm>

namespace sinew::bus {

std::string_view to_word(Verdict verdict)
{
    switch (verdict) {
    case Verdict::sent:
        return "sent";
    case Verdict::taken:
        return "taken";
    case Verdict::stray:
        return "stray";
    case Verdict::late:
        return "late";
    case Verdict::bad_checksum:
        return "bad_checksum";
    case Verdict::echo:
        return "echo";
    case Verdict::quarantined:
        return "quarantined";
    }
    return "";
}

Conversation::Conversation(const wire::Protocol& protocol, Line line, Settings settings)
    : protocol_(protocol), bare_(protocol.bare_replies()), line_(line), times_(line), settings_(settings),
      margin_(settings.margin_at_first)
{
    unusual_.double_read = settings.double_read;
}

void Conversation::begin(std::span<const wire::Request> requests, std::span<Result> results)
{
    for (auto& result : results)
        result.reset();
    if (stopping()) {
        for (std::size_t i = 0; i < results.size(); ++i)
            end(requests[i], results[i], Error{.code = Errc::stopped});
        return;
    }
    requests_ = requests;
    results_ = results;
    current_ = 0;
    open_ = waiting_count_ = results.size();
}

void Conversation::adopt(const wire::Request& request, Result& result)
{
    requests_ = {&request, 1};
    results_ = {&result, 1};
    current_ = 0;
    open_ = 1;
    waiting_count_ = 0;
    if (line_.can) {
        outstanding_.set(request.frame.can_id % outstanding_.size());
        sent_count_ = 1;
        on_wire_ = times_.predict(request).wire();
        first_expiry_ = result.deadline;
    }
}

void Conversation::end(const wire::Request& request, Result& result, const Error& error)
{
    result.stage = Result::Stage::done;
    result.error = error;
    result.error.id = request.id;
    result.error.message = request.message->name();
}

void Conversation::begin_stop(std::span<const wire::Request> requests, std::span<Result> results)
{
    stop_requests_ = requests;
    stop_results_ = results;
    unusual_.stop_due = true;
}

/// The frame boundary has come.
void Conversation::cut_in(TimePoint now)
{
    abandon(Error{.code = Errc::stopped}, now);
    begin(stop_requests_, stop_results_);
    unusual_.urgent = !stop_requests_.empty();
}

void Conversation::abandon(const Error& error, TimePoint now)
{
    for (std::size_t i = 0; unusual_.stop_due && i < stop_results_.size(); ++i) {
        stop_results_[i].reset();
        end(stop_requests_[i], stop_results_[i], error);
    }
    unusual_.stop_due = false;
    if (line_.can && sent_count_ > 0)
        clear_at_ = std::max(clear_at_, now) + on_wire_;
    if (unusual_.probing && !probe_result_.good)
        quarantine(now);
    unusual_.probing = unusual_.unproven = unusual_.urgent = false;
    // Of an exchange that has ended nothing is left to end, and its results may be gone.
    if (open_ != 0)
        for (std::size_t i = 0; i < results_.size(); ++i)
            if (results_[i].stage != Result::Stage::done)
                abandon(requests_[i], results_[i], error, now);
    open_ = waiting_count_ = sent_count_ = outbox_size_ = current_ = 0;
    requests_ = {};
    results_ = {};
    outstanding_.reset();
    on_wire_ = Duration{};
    drop_buffered(now);
}

void Conversation::abandon(const wire::Request& request, Result& result, const Error& error, TimePoint now)
{
    if (result.stage == Result::Stage::sent && request.answered) {
        if (bare_)
            quarantine(now);
        else
            lateness_.owe(request, result.deadline + settings_.late_max);
    }
    result.at = now;
    end(request, result, error);
}

void Conversation::distrust(TimePoint now)
{
    drop_buffered(now);
    if (bare_)
        quarantine(now);
    else
        lateness_.doubt_all(now + settings_.late_max);
}

Conversation::Next Conversation::next(TimePoint now)
{
    Next next = line_.can ? next_can(now) : next_serial(now);
    if (next.done) {
        // Requests and results are the caller's and need not live any longer.
        requests_ = {};
        results_ = {};
        unusual_.urgent = false;
    }
    return next;
}

/// Of an answer that several devices give.
bool Conversation::accept_from_one(const wire::Request& request, Result& result, const wire::Frame& frame, TimePoint at)
{
    for (std::size_t i = 0; i < result.reply_count; ++i)
        if (result.replies[i].can_id == frame.can_id)
            return false;
    tell(Verdict::taken, frame.bytes(), at, frame.can_id);
    result.replies[result.reply_count++] = frame;
    if (result.reply_count >= reply_count(request))
        finish(request, result, at);
    return true;
}

/// Told to be silent, but the protocol has an answer: should it come, it is nobody's.
void Conversation::finish_unanswered(const wire::Request& request, TimePoint at)
{
    if (!bare_ && request.message->reply.exists())
        lateness_.owe(request, at + request.response_time + settings_.late_max);
}

void Conversation::time_out(const wire::Request& request, Result& result, TimePoint now)
{
    const bool to_several = request.message->request.layout->can_fixed;
    if (!bare_)
        lateness_.owe(request, now + settings_.late_max);
    // A message for several devices is answered by those that are there.
    if (to_several && result.reply_count > 0) {
        finish(request, result, now);
        return;
    }
    count(&Counters::timeouts, request.id);
    give_up(request, result, Errc::timeout, now);
    drop_buffered(now);
    if (bare_)
        quarantine(now);
}

/// Again, or the end of it.
void Conversation::give_up(const wire::Request& request, Result& result, Errc why, TimePoint now)
{
    ++result.failures;
    result.reply_count = 0;
    if (may_repeat(request, result)) {
        result.stage = Result::Stage::waiting;
        ++waiting_count_;
        count(&Counters::retries, request.id);
        return;
    }
    result.stage = Result::Stage::done;
    result.at = now;
    result.error =
        Error{.code = why, .message = request.message->name(), .id = request.id, .elapsed = now - result.sent_at};
    if (!unusual_.probing)
        --open_;
}

bool Conversation::may_repeat(const wire::Request& request, const Result& result) const
{
    if (unusual_.probing || unusual_.urgent)
        return false;
    const wire::Info& info = request.message->info;
    if (info.access == wire::Access::read)
        return result.failures <= settings_.read_retries;
    return info.access == wire::Access::command && !info.relative && result.failures <= settings_.command_retries;
}

/// A whole frame that nobody waits for.
void Conversation::discard(const wire::Frame& frame, TimePoint at)
{
    if (const auto* asked = lateness_.settle(protocol_, frame, at)) {
        count(&Counters::late, asked->id);
        tell(Verdict::late, frame.bytes(), at, frame.can_id);
        return;
    }
    total_.strays += line_.can ? 1 : frame.size;
    tell(Verdict::stray, frame.bytes(), at, frame.can_id);
}

Duration Conversation::longest(std::span<const wire::Request> requests) const
{
    Duration sum{};
    for (const auto& request : requests) {
        const bool read = request.message->info.access == wire::Access::read;
        const int tries = 1 + std::max(0, read ? settings_.read_retries : settings_.command_retries);
        const int times = tries * (settings_.double_read && bare_ && read ? 2 : 1);
        const Exchange own = predict(line_, request);
        Duration once = own.total() + (request.answered ? settings_.margin_most : Duration{});
        if (const auto probe = protocol_.probe(request.id); bare_ && request.answered && probe)
            once += 10 * settings_.late_max + predict(line_, *probe).wire() + own.response + settings_.margin_most;
        sum += times * once;
    }
    return sum;
}

} // namespace sinew::bus
