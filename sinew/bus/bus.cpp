#include "sinew/bus/bus.hpp"

#include <algorithm>
#include <alloca.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace sinew::bus {
namespace {

/// How long a port may take no byte of a frame before it counts as stuck: much longer than any frame.
constexpr Duration write_patience = std::chrono::seconds(1);

bool is_can(const link::AnyLink& link)
{
    return std::holds_alternative<std::unique_ptr<link::CanLink>>(link);
}

link::LinkState state_of(const link::AnyLink& link)
{
    return std::visit([](const auto& l) { return l->state(); }, link);
}

} // namespace

Bus::Bus(std::string name, link::AnyLink link, link::Clock& clock, const wire::Protocol& protocol, Settings settings)
    : name_(std::move(name)), link_(std::move(link)), clock_(clock), protocol_(protocol),
      bare_(protocol.bare_replies()),
      conversation_(protocol, {.can = is_can(link_), .bit_rate = state_of(link_).bit_rate}, settings),
      stop_event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))
{
    choose_kind();
}

void Bus::choose_kind()
{
    const auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_);
    const auto* can = std::get_if<std::unique_ptr<link::CanLink>>(&link_);
    bytes_ = bytes != nullptr ? bytes->get() : nullptr;
    can_ = can != nullptr ? can->get() : nullptr;
    usual_handles_ = {link::Handle{bytes_ != nullptr ? bytes_->handle() : can_->handle()}, link::Handle{stop_event_}};
}

Bus::~Bus()
{
    if (stop_event_ >= 0)
        close(stop_event_);
}

void Bus::set_device(int id, Device device)
{
    if (id < 0 || id >= 256)
        return;
    devices_[slot_of(id)] = device;
    listed_[slot_of(id)] = nullptr;
}

bool Bus::look_up(int id, const wire::MessageInfo& message) const
{
    const bool has = device(id).line->has(message);
    if (has)
        listed_[slot_of(id)] = &message;
    return has;
}

link::LinkState Bus::link_state() const
{
    return state_of(link_);
}

std::expected<std::uint32_t, Error> Bus::set_bit_rate(std::uint32_t bit_rate)
{
    auto set = std::visit([&](auto& l) { return l->set_bit_rate(bit_rate); }, link_);
    if (set) {
        conversation_.set_bit_rate(*set);
        asked_bit_rate_ = bit_rate;
    }
    return set;
}

void Bus::set_stop(std::span<const wire::Request> requests, TimePoint until, std::span<const wire::Request> later)
{
    const std::size_t most = std::max(requests.size(), later.size());
    for (auto* all : {&stop_requests_, &later_stop_requests_})
        all->reserve(most); // a cycle changes one for the other
    stop_requests_.assign(requests.begin(), requests.end());
    later_stop_requests_.assign(later.begin(), later.end());
    stop_until_ = until;
    stop_results_.resize(std::max(stop_results_.size(), most));
}

StopBound Bus::stop_bound(std::span<const wire::Request> running) const
{
    StopBound bound = predict_stop(conversation_.line(), running, stop_requests_);
    if (stop_until_ != TimePoint::max()) {
        const StopBound later = predict_stop(conversation_.line(), running, later_stop_requests_);
        bound = {std::max(bound.begins, later.begins), std::max(bound.first, later.first),
                 std::max(bound.ends, later.ends)};
    }
    return bound;
}

void Bus::request_stop() noexcept
{
    stop_.store(true);
    const std::uint64_t one = 1;
    // Only a full counter fails here, and then the waiter wakes all the same.
    [[maybe_unused]] const auto written = ::write(stop_event_, &one, sizeof one);
}

/// A stop that was asked for would end every wait.
void Bus::end_wake() noexcept
{
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(stop_event_, &count, sizeof count);
}

void Bus::clear_stop() noexcept
{
    end_wake();
    stop_begun_ = false;
    stop_.store(false);
}

void Bus::stop()
{
    request_stop();
    Bus* const self = this;
    drive({&self, 1});
}

/// A frame that has begun is finished before: half a frame would garble the stop.
void Bus::obey_stop()
{
    if (!stop_begun_)
        end_wake();
    if (written_ > 0)
        return;
    if (stop_begun_) {
        if (!conversation_.stopping())
            conversation_.abandon({.code = Errc::stopped}, clock_.now());
        return;
    }
    stop_begun_ = true;
    said_later_ = clock_.now() > stop_until_;
    const auto& requests = said_later_ ? later_stop_requests_ : stop_requests_;
    stop_size_ = requests.size();
    conversation_.begin_stop(requests, std::span(stop_results_).first(stop_size_));
}

void Bus::start(std::span<const wire::Request> requests, std::span<Result> results)
{
    if (conversation_.busy() && !conversation_.stopping())
        conversation_.abandon({.code = Errc::stopped}, clock_.now());
    if (!conversation_.stopping())
        abandoned_part_ = written_ > 0;
    look_ = protocol_.bare_replies();
    conversation_.begin(requests, results);
    ended_by_loss_ = std::exchange(trouble_.untold, false);
    if (ended_by_loss_)
        conversation_.abandon(lost_error_, clock_.now());
}

std::span<const link::Handle> Bus::handles()
{
    const int fd = bytes_ != nullptr ? bytes_->handle() : can_->handle();
    handles_ = {link::Handle{fd, trouble_.blocked}, link::Handle{stop_event_, false}};
    return handles_;
}

void Bus::end_with(const Error& error)
{
    written_ = 0;
    abandoned_part_ = false;
    trouble_.blocked = false;
    // A link that stays open, such as an SLCAN adapter that refused one frame, serves the next exchange.
    if (!link_state().open) {
        trouble_.lost = true;
        lost_error_ = error;
        ++losses_;
        next_try_ = clock_.now();
        ended_by_loss_ = conversation_.busy();
        trouble_.untold = !ended_by_loss_;
        stop_begun_ = false; // it goes out when the link is back
    }
    conversation_.abandon(error, clock_.now());
    if (trouble_.lost)
        for (Bus* other : stopped_with_)
            other->request_stop();
}

void Bus::read_link()
{
    if (can_ != nullptr) {
        while (take_frames(can_->read(inbox_), inbox_)) {
        }
        return;
    }
    std::array<std::uint8_t, read_size> buffer;
    while (take(bytes_->read(buffer), buffer)) {
    }
}

/// What one read brought. Whether to read again.
bool Bus::take(const std::expected<link::Arrival, Error>& got, std::span<const std::uint8_t> buffer)
{
    if (!got) {
        end_with(got.error());
        return false;
    }
    conversation_.received(buffer.first(got->count), got->at);
    return got->more || got->count == buffer.size();
}

bool Bus::take_frames(const std::expected<link::Arrival, Error>& got, std::span<const wire::Frame> frames)
{
    if (!got) {
        end_with(got.error());
        return false;
    }
    // What is not over yet keeps its answers where these may stand.
    for (const wire::Frame& frame : frames.first(got->count))
        conversation_.received(wire::Frame{frame}, got->at);
    return got->more || got->count == frames.size();
}

/// How many whole frames that makes, when the link took `count` bytes of `frame`.
std::size_t Bus::take_note(const wire::Frame& frame, std::size_t count)
{
    if (written_ + count == frame.size) {
        written_ = 0;
        return 1;
    }
    part_ = frame;
    written_ += count;
    return 0;
}

/// Hands over what fits. False: not one frame did.
bool Bus::write(std::span<const wire::Frame> frames, TimePoint& now)
{
    return note_written(hand_over(frames), frames.front(), now);
}

/// What the link took of them: bytes of the first one, or frames.
std::expected<std::size_t, Error> Bus::hand_over(std::span<const wire::Frame> frames)
{
    return bytes_ != nullptr ? bytes_->write(frames.front().bytes().subspan(written_)) : can_->write(frames);
}

bool Bus::note_written(const std::expected<std::size_t, Error>& wrote, const wire::Frame& first, TimePoint& now)
{
    if (!wrote) {
        end_with(wrote.error());
        return true;
    }
    now = clock_.now();
    const std::size_t count = bytes_ != nullptr ? take_note(first, *wrote) : *wrote;
    if (count > 0) {
        trouble_.blocked = false;
        if (std::exchange(abandoned_part_, false) || !conversation_.busy()) [[unlikely]]
            conversation_.distrust(now); // the rest of a frame that nobody waits for: what it brings is nobody's
        else
            conversation_.transmitted(count, now);
        return true;
    }
    if (!trouble_.blocked) {
        trouble_.blocked = true;
        write_deadline_ = now + write_patience;
    }
    if (now < write_deadline_)
        return false;
    end_with(Error{.code = Errc::link_failed, .detail = "the port takes no bytes any more; is its other end stuck?"});
    return true;
}

bool Bus::work()
{
    if (trouble_.lost)
        try_to_reopen();
    else if (look_)
        read_link();
    look_ = true;
    // A stop waits for the rest of a frame even where the exchange that it was of is over.
    if (!conversation_.busy() && !has_news() && written_ == 0)
        return true;
    TimePoint now = clock_.now();
    for (;;) {
        if (stop_.load(std::memory_order_relaxed) && !trouble_.lost) [[unlikely]]
            obey_stop();
        if (trouble_.lost) [[unlikely]] {
            ended_by_loss_ = ended_by_loss_ || conversation_.busy();
            conversation_.abandon(lost_error_, now);
        }
        const auto next = conversation_.next(now);
        const bool in_part = written_ > 0;
        if (next.done && !in_part)
            return true;
        deadline_ = next.deadline;
        if (!in_part && next.transmit.empty())
            return false;
        if (write(in_part ? std::span<const wire::Frame>(&part_, 1) : next.transmit, now))
            continue;
        deadline_ = std::min(deadline_, write_deadline_);
        return false;
    }
}

std::expected<void, Error> Bus::exchange(std::span<const wire::Request> requests, std::span<Result> results)
{
    const bool is_plain = requests.size() == 1 && requests[0].answered && requests[0].message->reply.exists() &&
                          !requests[0].message->request.layout->can_fixed;
    if (is_plain)
        one(requests[0], results[0]);
    else
        run(requests, results);
    if (ended_by_loss_)
        return std::unexpected(lost_error_);
    return {};
}

void Bus::run(std::span<const wire::Request> requests, std::span<Result> results)
{
    start(requests, results);
    while (!work())
        clock_.wait(handles(), deadline_);
}

bool drive(std::span<Bus* const> buses, TimePoint until)
{
    // Link and stop of each, however many: on the stack, for here nothing is asked of the heap.
    auto* const handles = static_cast<link::Handle*>(::alloca(2 * buses.size() * sizeof(link::Handle)));
    for (;;) {
        std::size_t count = 0;
        TimePoint deadline = until;
        bool open = false;
        for (Bus* bus : buses) {
            const bool ended = bus->work();
            open = open || !ended;
            if (!ended)
                deadline = std::min(deadline, bus->deadline());
            if (ended && bus->link_trouble() != nullptr)
                continue;
            // One that has nothing to do may be told to stop.
            for (const auto& handle : ended ? bus->handles().last(1) : bus->handles())
                handles[count++] = handle;
        }
        if (std::ranges::any_of(buses, &Bus::has_news))
            continue;
        if (!open)
            return true;
        link::Clock& clock = buses.front()->clock();
        if (until != TimePoint::max() && clock.now() >= until)
            return false;
        clock.wait({handles, count}, deadline);
    }
}

} // namespace sinew::bus
