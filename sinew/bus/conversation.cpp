#include "sinew/bus/conversation.hpp"

#include <algorithm>

namespace sinew::bus {
Conversation::Conversation(const wire::Protocol& protocol, Line line, Settings settings)
    : protocol_(protocol), line_(line), settings_(settings), margin_(settings.margin_at_first)
{
}

void Conversation::begin(std::span<const wire::Request> requests, std::span<Result> results)
{
    requests_ = requests;
    results_ = results;
    current_ = 0;
    for (auto& result : results_)
        result = {};
}

bool Conversation::busy() const
{
    return std::ranges::any_of(results_, [](const Result& r) { return r.stage != Result::Stage::done; });
}

void Conversation::abandon(const Error& error, TimePoint now)
{
    probing_ = unproven_ = false;
    sending_ = nullptr;
    buffered_ = 0;
    for (std::size_t i = 0; i < results_.size(); ++i) {
        Result& result = results_[i];
        if (result.stage == Result::Stage::done)
            continue;
        if (result.stage == Result::Stage::sent && requests_[i].answered && protocol_.bare_replies())
            quarantine(now);
        result.stage = Result::Stage::done;
        result.error = error;
        result.error.id = requests_[i].id;
        result.error.message = requests_[i].message->name();
    }
}

void Conversation::distrust(TimePoint now)
{
    buffered_ = 0;
    if (protocol_.bare_replies())
        quarantine(now);
    else
        doubtful_until_ = now + settings_.late_max;
}

Conversation::Next Conversation::next(TimePoint now)
{
    return line_.can ? next_can(now) : next_serial(now);
}

Conversation::Next Conversation::send(const wire::Request& request, Result& result, TimePoint now)
{
    result.sent_at = now;
    sending_ = &result;
    sending_request_ = &request;
    return {.transmit = &request.frame};
}

void Conversation::transmitted(TimePoint now)
{
    Result& result = *sending_;
    const wire::Request& request = *sending_request_;
    sending_ = nullptr;
    unproven_ = false;
    result.stage = Result::Stage::sent;
    ++result.tries;
    ++total_.requests;
    ++per_id_[slot_of(request.id)].requests;
    // On CAN the answers of all that is outstanding share the wire with this one.
    const auto outstanding =
        line_.can ? std::max<std::int64_t>(1, std::ranges::count(results_, Result::Stage::sent, &Result::stage)) : 1;
    result.deadline = now + outstanding * predict(line_, request).wire() +
                      (request.answered ? request.response_time + margin_ : Duration{});
}

Conversation::Next Conversation::next_serial(TimePoint now)
{
    while (current_ < requests_.size()) {
        const wire::Request& request = *current_request();
        Result& result = *current_result();
        if (result.stage == Result::Stage::waiting) {
            const bool trusted = !quarantined_ || !request.answered || unproven_;
            if (!trusted && now < quiet_until_)
                return {.deadline = quiet_until_};
            if (!trusted && !probing_) {
                quarantined_ = false;
                buffered_ = 0;
                if (begin_probe(request))
                    continue;
            }
            return send(request, result, now);
        }
        if (result.stage == Result::Stage::sent) {
            if (now < result.deadline)
                return {.deadline = result.deadline};
            if (request.answered)
                take_bytes(true, now);
            if (result.stage == Result::Stage::sent)
                request.answered ? time_out(request, result, now) : finish(request, result, now);
            continue;
        }
        if (probing_)
            end_probe();
        else
            ++current_;
    }
    return {.done = true};
}

Conversation::Next Conversation::next_can(TimePoint now)
{
    TimePoint deadline = TimePoint::max();
    bool open = false;
    for (std::size_t i = 0; i < requests_.size(); ++i) {
        Result& result = results_[i];
        if (result.stage == Result::Stage::sent && now >= result.deadline)
            requests_[i].answered ? time_out(requests_[i], result, now) : finish(requests_[i], result, now);
        if (result.stage == Result::Stage::waiting && identifier_free(i))
            return send(requests_[i], result, now);
        open = open || result.stage != Result::Stage::done;
        if (result.stage == Result::Stage::sent)
            deadline = std::min(deadline, result.deadline);
    }
    return {.deadline = deadline, .done = !open};
}

bool Conversation::identifier_free(std::size_t index) const
{
    for (std::size_t i = 0; i < requests_.size(); ++i) {
        if (i == index || results_[i].stage == Result::Stage::done)
            continue;
        const bool shared = requests_[i].frame.can_id == requests_[index].frame.can_id ||
                            requests_[i].message->request.layout->can_fixed ||
                            requests_[index].message->request.layout->can_fixed;
        // Requests that share an identifier go out in the order in which they stand.
        if (shared && (results_[i].stage == Result::Stage::sent || i < index))
            return false;
    }
    return true;
}

bool Conversation::begin_probe(const wire::Request& request)
{
    auto probe = protocol_.probe(request.id);
    if (!probe || probe->message == request.message)
        return false;
    probe_ = *probe;
    probe_.response_time = request.response_time;
    probe_result_ = {};
    probing_ = true;
    return true;
}

void Conversation::end_probe()
{
    probing_ = false;
    if (probe_result_.good)
        return;
    quarantined_ = true;
    if (requests_[current_].message->info.access != wire::Access::read) {
        unproven_ = true;
        return;
    }
    // The device does not answer at all: a read needs no further wait.
    Result& result = results_[current_];
    result.error = probe_result_.error;
    result.error.message = requests_[current_].message->name();
    result.stage = Result::Stage::done;
}

const wire::Request* Conversation::current_request() const
{
    return probing_ ? &probe_ : &requests_[current_];
}

Result* Conversation::current_result()
{
    return probing_ ? &probe_result_ : &results_[current_];
}

void Conversation::received(std::span<const std::uint8_t> bytes, TimePoint at)
{
    while (!bytes.empty()) {
        const std::size_t room = std::min(bytes.size(), buffer_.size() - buffered_);
        std::copy_n(bytes.begin(), room, buffer_.begin() + static_cast<std::ptrdiff_t>(buffered_));
        buffered_ += room;
        bytes = bytes.subspan(room);
        take_bytes(false, at);
        if (buffered_ == buffer_.size())
            take_bytes(true, at);
    }
}

void Conversation::received(const wire::Frame& frame, TimePoint at)
{
    take(frame, at);
}

void Conversation::take_bytes(bool silent, TimePoint at)
{
    while (buffered_ > 0) {
        const bool asked = current_ < requests_.size() && current_result()->stage == Result::Stage::sent &&
                           current_request()->answered;
        // Bare bytes that nobody waits for mean nothing.
        if (!asked && protocol_.bare_replies()) {
            stray(buffered_, at);
            buffered_ = 0;
            return;
        }
        const std::size_t awaited = asked ? current_request()->message->reply.size : 0;
        const auto scan = protocol_.find_reply(std::span(buffer_).first(buffered_), awaited, silent);
        if (scan.skip > 0)
            stray(scan.skip, at);
        wire::Frame frame{.size = static_cast<std::uint8_t>(scan.size)};
        std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(scan.skip), scan.size, frame.data.begin());
        const std::size_t used = scan.skip + scan.size;
        std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(used),
                  buffer_.begin() + static_cast<std::ptrdiff_t>(buffered_), buffer_.begin());
        buffered_ -= used;
        if (scan.size > 0)
            take(frame, at);
        else if (used == 0 || !silent)
            return;
    }
}

void Conversation::take(const wire::Frame& frame, TimePoint at)
{
    if (!line_.can) {
        if (current_ < requests_.size() && accept(*current_request(), *current_result(), frame, at))
            return;
    } else {
        for (std::size_t i = 0; i < requests_.size(); ++i)
            if (accept(requests_[i], results_[i], frame, at))
                return;
    }
    for (const auto& timeout : timeouts_)
        if (timeout.message != nullptr && at <= timeout.until && wire::selects(timeout.message->reply, frame)) {
            ++total_.late;
            ++per_id_[slot_of(timeout.id)].late;
            return;
        }
    stray(line_.can ? 1 : frame.size, at);
}

bool Conversation::accept(const wire::Request& request, Result& result, const wire::Frame& frame, TimePoint at)
{
    if (result.stage != Result::Stage::sent || !request.answered ||
        !protocol_.answers(request.frame, *request.message, frame, request.options))
        return false;
    result.replies[result.reply_count++] = frame;
    const bool more_due = request.message->request.layout->can_fixed && result.reply_count < result.replies.size();
    if (!more_due)
        finish(request, result, at);
    return true;
}

void Conversation::finish(const wire::Request& request, Result& result, TimePoint at)
{
    result.stage = Result::Stage::done;
    result.good = true;
    result.at = at;
    if (!request.answered)
        return;
    const Duration took = at - result.sent_at;
    for (auto* counters : {&total_, &per_id_[slot_of(request.id)]}) {
        counters->replies += result.reply_count;
        counters->add_round_trip(took);
    }
    learn(took - predict(line_, request).wire() - request.response_time);
    result.possibly_older = at <= doubtful_until_;
    for (const auto& timeout : timeouts_)
        if (timeout.id == request.id && timeout.message == request.message && at <= timeout.until)
            result.possibly_older = true;
}

void Conversation::time_out(const wire::Request& request, Result& result, TimePoint now)
{
    // A message for several devices is answered by those that are there.
    if (result.reply_count > 0) {
        finish(request, result, now);
        return;
    }
    auto& device = per_id_[slot_of(request.id)];
    ++total_.timeouts;
    ++device.timeouts;
    timeouts_[next_timeout_++ % timeouts_.size()] = {request.id, request.message, now + settings_.late_max};
    if (protocol_.bare_replies())
        quarantine(now);
    if (request.message->info.access == wire::Access::read && result.tries <= settings_.read_retries && !probing_) {
        result.stage = Result::Stage::waiting;
        ++total_.retries;
        ++device.retries;
        return;
    }
    result.stage = Result::Stage::done;
    result.error = Error{
        .code = Errc::timeout, .message = request.message->name(), .id = request.id, .elapsed = now - result.sent_at};
    keep_seen(result.error, std::span(buffer_).first(buffered_));
    buffered_ = 0;
}

void Conversation::stray(std::size_t count, TimePoint at)
{
    total_.strays += count;
    if (quarantined_)
        quiet_until_ = std::min(at + settings_.late_max, quarantine_ends_);
    else if (protocol_.bare_replies())
        quarantine(at); // bytes without an owner: the next ones could be taken for an answer
}

void Conversation::quarantine(TimePoint now)
{
    quarantined_ = true;
    quiet_until_ = now + settings_.late_max;
    // A line that never falls silent is probed all the same, after a while.
    quarantine_ends_ = now + 10 * settings_.late_max;
    ++total_.quarantines;
}

/// The margin follows the slowest recent answer: twice what the link added, forgetting slowly.
void Conversation::learn(Duration excess)
{
    excess_ = std::max(excess, excess_ - excess_ / 64);
    if (++measured_ >= 8)
        margin_ = std::clamp(2 * excess_, settings_.margin_least, settings_.margin_at_first * 4);
}

} // namespace sinew::bus
