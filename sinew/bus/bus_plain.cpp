#include "sinew/bus/bus.hpp"
#include "sinew/bus/conversation_hot.hpp"

/// An exchange of one request that one device is to answer, on its usual way: the steps of `Bus::work` without the
/// questions that it asks for the other ways. At the first oddity `work` takes over.
namespace sinew::bus {

/// Time is asked for once before the write and once by the read: what the write takes makes the wait longer, never
/// shorter.
void Bus::one(const wire::Request& request, Result& result)
{
    if (trouble_.any() || stop_.load(std::memory_order_relaxed) || !conversation_.is_calm()) [[unlikely]]
        return run({&request, 1}, {&result, 1});
    ended_by_loss_ = false;
    can_ == nullptr ? one_in_bytes(request, result) : one_in_frames(request, result);
}

void Bus::one_in_bytes(const wire::Request& request, Result& result)
{
    if (bare_ && !is_silent()) [[unlikely]] {
        if (!trouble_.lost)
            return run({&request, 1}, {&result, 1});
        return start({&request, 1}, {&result, 1}); // tells of the loss; the next exchange tries to open the link
    }
    const TimePoint now = clock_.now();
    const auto wrote = bytes_->write(request.frame.bytes());
    if (!wrote || *wrote != request.frame.size) [[unlikely]]
        return half_written(request, result, wrote, now);
    Counters& own = conversation_.own_counters(request.id);
    conversation_.sent_plain<false>(request, result, own, now);
    clock_.wait_since(now, usual_handles_, result.deadline);
    std::array<std::uint8_t, read_size> buffer;
    const auto got = bytes_->read(buffer);
    if (!got || !conversation_.answered_plain(request, result, own, std::span(buffer).first(got->count), got->at))
        [[unlikely]] {
        conversation_.adopt(request, result);
        if (take(got, buffer))
            read_link();
        return go_on();
    }
    if (got->more) [[unlikely]]
        read_link();
    if (stop_.load(std::memory_order_relaxed)) [[unlikely]]
        go_on();
}

void Bus::one_in_frames(const wire::Request& request, Result& result)
{
    const TimePoint now = clock_.now();
    const auto wrote = can_->write({&request.frame, 1});
    if (!wrote || *wrote != 1) [[unlikely]]
        return half_written(request, result, wrote, now);
    Counters& own = conversation_.own_counters(request.id);
    conversation_.sent_plain<true>(request, result, own, now);
    clock_.wait_since(now, usual_handles_, result.deadline);
    const auto got = can_->read(result.replies);
    if (!got || got->count != 1 || !conversation_.answered_plain(request, result, own, got->at)) [[unlikely]] {
        conversation_.adopt(request, result);
        if (take_frames(got, result.replies))
            read_link();
        return go_on();
    }
    if (got->more) [[unlikely]]
        read_link();
    if (stop_.load(std::memory_order_relaxed)) [[unlikely]]
        go_on();
}

/// Whether nothing came that nobody asked for.
[[gnu::always_inline]] inline bool Bus::is_silent()
{
    std::array<std::uint8_t, read_size> buffer;
    const auto got = bytes_->read(buffer);
    if (got && got->count == 0) [[likely]]
        return true;
    if (take(got, buffer))
        read_link();
    return false;
}

/// What `run` does after a first look at the link.
void Bus::go_on()
{
    look_ = false;
    while ((conversation_.busy() || has_news()) && !work())
        clock_.wait(handles(), deadline_);
}

void Bus::half_written(const wire::Request& request, Result& result, const std::expected<std::size_t, Error>& wrote,
                       TimePoint before)
{
    TimePoint now = before;
    conversation_.begin({&request, 1}, {&result, 1});
    (void)conversation_.next(before);
    (void)note_written(wrote, request.frame, now);
    go_on();
}

} // namespace sinew::bus
