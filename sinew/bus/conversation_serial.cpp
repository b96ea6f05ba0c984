#include "sinew/bus/agree.hpp"
#include "sinew/bus/conversation_hot.hpp"

#include <algorithm>
#include <utility>

/// Serial lines: one request after the other, framed replies or bare ones.
namespace sinew::bus {

/// Of an exchange that has ended nothing is looked at any more: requests and results may be gone.
bool Conversation::in_flight() const
{
    return open_ != 0 && current_result()->stage == Result::Stage::sent;
}

Conversation::Next Conversation::next_serial(TimePoint now)
{
    if (unusual_.stop_due) [[unlikely]] {
        // The answer in progress would garble the stop, but no margin of the host is waited for.
        if (in_flight() && now < current_result()->due)
            return {.deadline = current_result()->due};
        cut_in(now);
    }
    while (current_ < requests_.size()) {
        const wire::Request& request = *current_request();
        Result& result = *current_result();
        if (result.stage == Result::Stage::waiting) {
            const bool trusted = !unusual_.quarantined || !request.answered || unusual_.unproven || unusual_.urgent;
            if (!trusted && now < quiet_until_)
                return {.deadline = quiet_until_};
            if (!trusted && !unusual_.probing) {
                unusual_.quarantined = false;
                drop_buffered(now);
                begin_probe(request);
                continue;
            }
            result.sent_at = now;
            return {.transmit = {&request.frame, 1}};
        }
        if (result.stage == Result::Stage::sent) {
            if (now < result.deadline)
                return {.deadline = result.deadline};
            const auto heard = std::span(buffer_).first(buffered_);
            if (request.answered && !bare_)
                buffered_ -= receive_framed(heard, true, now);
            if (result.stage == Result::Stage::sent)
                request.answered ? time_out(request, result, now) : finish(request, result, now);
            keep_seen(result.error, heard);
            continue;
        }
        if (unusual_.probing)
            end_probe(now);
        else
            ++current_;
    }
    return {.done = true};
}

void Conversation::transmitted(std::size_t count, TimePoint now)
{
    if (line_.can)
        return transmitted_can(count, now);
    const wire::Request& request = *current_request();
    Result& result = *current_result();
    const Exchange exchange = times_.predict(request);
    earliest_ = earliest(exchange.request, exchange.replies, result.sent_at);
    sent(request, result, now + exchange.total(), now);
    unusual_.unproven = false;
}

/// For `double_read`: whether the answer was asked twice and both agree. If not, it goes out again.
bool Conversation::is_confirmed(const wire::Request& request, Result& result, TimePoint at)
{
    if (!bare_ || unusual_.probing || unusual_.urgent || request.message->info.access != wire::Access::read)
        return true;
    if (result.reply_count == 1) {
        result.stage = Result::Stage::waiting;
        return false;
    }
    if (agree(request.message->reply, result.replies[0], result.replies[1])) {
        result.reply_count = 1;
        result.replies[0] = result.replies[1];
        return true;
    }
    count(&Counters::disagreements, request.id);
    give_up(request, result, Errc::bad_reply, at);
    return false;
}

/// Of a device that has one, unless it is what is asked: then the line is trusted without it.
void Conversation::begin_probe(const wire::Request& request)
{
    auto probe = protocol_.probe(request.id);
    if (!probe || probe->message == request.message)
        return;
    probe_ = *probe;
    probe_.response_time = request.response_time;
    probe_result_.reset();
    unusual_.probing = true;
    ++open_;
}

void Conversation::end_probe(TimePoint now)
{
    const bool proven = probe_result_.good;
    if (!proven)
        --open_;
    unusual_.probing = false;
    if (proven)
        return;
    const wire::Request& request = requests_[current_];
    if (request.message->info.access != wire::Access::read) {
        unusual_.unproven = true;
        return;
    }
    // The device does not answer at all: a read needs no further wait.
    Result& result = results_[current_];
    result.error = probe_result_.error;
    result.error.message = request.message->name();
    result.stage = Result::Stage::done;
    result.at = now;
    --open_;
}

void Conversation::received(std::span<const std::uint8_t> bytes, TimePoint at)
{
    if (bare_) {
        receive_bare(bytes, at);
        return;
    }
    if (buffered_ == 0)
        bytes = bytes.subspan(receive_framed(bytes, false, at));
    while (!bytes.empty()) {
        const std::size_t room = std::min(bytes.size(), buffer_.size() - buffered_);
        std::copy_n(bytes.begin(), room, buffer_.begin() + static_cast<std::ptrdiff_t>(buffered_));
        buffered_ += room;
        bytes = bytes.subspan(room);
        const auto held = std::span(buffer_).first(buffered_);
        const std::size_t used = receive_framed(held, buffered_ == buffer_.size(), at);
        std::ranges::copy(held.subspan(used), buffer_.begin());
        buffered_ -= used;
    }
}

/// Exactly as many bytes as are due, between the request and the deadline, are an answer. One too many, and it is not
/// to be told which of them are.
void Conversation::receive_bare(std::span<const std::uint8_t> bytes, TimePoint at)
{
    if (bytes.empty())
        return;
    if (unusual_.quarantined || !in_flight() || !current_request()->answered || at < earliest_) [[unlikely]] {
        stray(unusual_.quarantined ? Verdict::quarantined : Verdict::stray, bytes, at);
        return;
    }
    const wire::Request& request = *current_request();
    const std::size_t awaited = request.message->reply.size;
    if (buffered_ > 0 || bytes.size() < awaited) [[unlikely]] {
        if (buffered_ + bytes.size() > awaited) {
            drop_buffered(at);
            stray(Verdict::stray, bytes, at);
            return;
        }
        std::ranges::copy(bytes, buffer_.begin() + static_cast<std::ptrdiff_t>(buffered_));
        buffered_ += bytes.size();
        if (buffered_ < awaited)
            return;
        bytes = std::span(buffer_).first(std::exchange(buffered_, 0));
    }
    if (bytes.size() == awaited && accept(request, *current_result(), wire::Frame::of(bytes), at)) [[likely]]
        return;
    stray(Verdict::stray, bytes, at);
}

/// Returns how many bytes have been dealt with. `silent`: no more will come.
std::size_t Conversation::receive_framed(std::span<const std::uint8_t> bytes, bool silent, TimePoint at)
{
    std::size_t used = 0;
    while (used < bytes.size()) {
        const bool awaits = in_flight() && current_request()->answered;
        const auto rest = bytes.subspan(used);
        const auto scan = protocol_.find_reply(rest, awaits ? current_request()->message->reply.size : 0, silent);
        if (scan.skip > 0) {
            if (scan.bad_checksum)
                count(&Counters::bad_checksums, awaits ? current_request()->id : -1);
            stray(scan.bad_checksum ? Verdict::bad_checksum : Verdict::stray, rest.first(scan.skip), at);
        }
        used += scan.skip + scan.size;
        if (scan.size == 0)
            break;
        const wire::Frame frame = wire::Frame::of(rest.subspan(scan.skip, scan.size));
        if (awaits && at >= earliest_ && accept(*current_request(), *current_result(), frame, at)) [[likely]]
            continue;
        if (const auto* own = own_request(frame)) {
            count(&Counters::echoes, own->id);
            tell(Verdict::echo, frame.bytes(), at);
        } else {
            discard(frame, at);
        }
    }
    return silent ? bytes.size() : used;
}

/// The request that a frame is an echo of: the one in flight, or the one before it.
const wire::Request* Conversation::own_request(const wire::Frame& frame) const
{
    if (in_flight() && frame == current_request()->frame)
        return current_request();
    const bool has_one_before = open_ != 0 && current_ > 0;
    return has_one_before && frame == requests_[current_ - 1].frame ? &requests_[current_ - 1] : nullptr;
}

/// Bytes without an owner. On a line of bare replies the next ones could be taken for an answer.
void Conversation::stray(Verdict verdict, std::span<const std::uint8_t> bytes, TimePoint at)
{
    total_.strays += bytes.size();
    tell(verdict, bytes, at);
    if (unusual_.quarantined)
        quiet_until_ = std::min(at + settings_.late_max, quarantine_ends_);
    else if (bare_)
        quarantine(at);
}

void Conversation::drop_buffered(TimePoint at)
{
    if (buffered_ == 0)
        return;
    total_.strays += buffered_;
    tell(Verdict::stray, std::span(buffer_).first(buffered_), at);
    buffered_ = 0;
}

void Conversation::quarantine(TimePoint now)
{
    drop_buffered(now);
    unusual_.quarantined = true;
    quiet_until_ = now + settings_.late_max;
    // A line that never falls silent is probed all the same, after a while.
    quarantine_ends_ = now + 10 * settings_.late_max;
    ++total_.quarantines;
}

} // namespace sinew::bus
