#include "sinew/bus/bus.hpp"

#include <algorithm>
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
      conversation_(protocol, {.can = is_can(link_), .bit_rate = state_of(link_).bit_rate}, settings),
      stop_event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))
{
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

bool Bus::is_listed(int id, const wire::MessageInfo& message) const
{
    const wire::MessageInfo*& listed = listed_[slot_of(id)];
    if (listed != &message && device(id).line->has(message))
        listed = &message;
    return listed == &message;
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

void Bus::set_stop(std::span<const wire::Request> requests)
{
    stop_requests_.assign(requests.begin(), requests.end());
    stop_results_.assign(requests.size(), {});
}

void Bus::request_stop() noexcept
{
    stop_.store(true);
    const std::uint64_t one = 1;
    // Only a full counter fails here, and then the waiter wakes all the same.
    [[maybe_unused]] const auto written = ::write(stop_event_, &one, sizeof one);
}

void Bus::clear_stop() noexcept
{
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(stop_event_, &count, sizeof count);
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
    if (stop_begun_) {
        if (!conversation_.stopping())
            conversation_.abandon({.code = Errc::stopped}, clock_.now());
        return;
    }
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(stop_event_, &count, sizeof count); // or it would end every wait
    stop_begun_ = true;
    conversation_.begin_stop(stop_requests_, stop_results_);
}

void Bus::start(std::span<const wire::Request> requests, std::span<Result> results)
{
    if (conversation_.busy() && !conversation_.stopping())
        conversation_.abandon({.code = Errc::stopped}, clock_.now());
    look_ = protocol_.bare_replies();
    conversation_.begin(requests, results);
    ended_by_loss_ = std::exchange(untold_, false);
    if (ended_by_loss_)
        conversation_.abandon(lost_error_, clock_.now());
}

std::span<const link::Handle> Bus::handles()
{
    const int fd = std::visit([](const auto& l) { return l->handle(); }, link_);
    handles_ = {link::Handle{fd, blocked_}, link::Handle{stop_event_, false}};
    return handles_;
}

void Bus::end_with(const Error& error)
{
    written_ = 0;
    blocked_ = false;
    // A link that stays open, such as an SLCAN adapter that refused one frame, serves the next exchange.
    if (!link_state().open) {
        lost_ = true;
        lost_error_ = error;
        ++losses_;
        next_try_ = clock_.now();
        ended_by_loss_ = conversation_.busy();
        untold_ = !ended_by_loss_;
        stop_begun_ = false; // it goes out when the link is back
    }
    conversation_.abandon(error, clock_.now());
    if (lost_)
        for (Bus* other : stopped_with_)
            other->request_stop();
}

void Bus::read_link()
{
    if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_)) {
        std::array<std::uint8_t, 256> buffer;
        for (;;) {
            const auto got = (*bytes)->read(buffer);
            if (!got)
                return end_with(got.error());
            conversation_.received(std::span(buffer).first(got->count), got->at);
            if (!got->more && got->count < buffer.size())
                return;
        }
    }
    std::array<wire::Frame, 64> frames;
    for (;;) {
        const auto got = std::get<std::unique_ptr<link::CanLink>>(link_)->read(frames);
        if (!got)
            return end_with(got.error());
        for (const auto& frame : std::span(frames).first(got->count))
            conversation_.received(frame, got->at);
        if (!got->more && got->count < frames.size())
            return;
    }
}

std::expected<std::size_t, Error> Bus::write_bytes(link::ByteLink& link, const wire::Frame& frame)
{
    const auto wrote = link.write(frame.bytes().subspan(written_));
    if (!wrote)
        return wrote;
    if (written_ + *wrote == frame.size) {
        written_ = 0;
        return 1U;
    }
    if (written_ == 0 && *wrote > 0)
        part_ = frame;
    written_ += *wrote;
    return 0U;
}

/// Hands over what fits. False: not one frame did.
bool Bus::write(std::span<const wire::Frame> frames, TimePoint& now)
{
    auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_);
    const auto wrote = bytes != nullptr ? write_bytes(**bytes, frames.front())
                                        : std::get<std::unique_ptr<link::CanLink>>(link_)->write(frames);
    if (!wrote) {
        end_with(wrote.error());
        return true;
    }
    now = clock_.now();
    if (*wrote > 0) {
        blocked_ = false;
        conversation_.transmitted(*wrote, now);
        return true;
    }
    if (!blocked_) {
        blocked_ = true;
        write_deadline_ = now + write_patience;
    }
    if (now < write_deadline_)
        return false;
    end_with(Error{.code = Errc::link_failed, .detail = "the port takes no bytes any more; is its other end stuck?"});
    return true;
}

bool Bus::work()
{
    if (lost_)
        try_to_reopen();
    else if (look_)
        read_link();
    look_ = true;
    if (!conversation_.busy() && !has_news())
        return true;
    TimePoint now = clock_.now();
    for (;;) {
        if (stop_.load(std::memory_order_relaxed) && written_ == 0 && !lost_) [[unlikely]]
            obey_stop();
        if (lost_) [[unlikely]] {
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
    start(requests, results);
    while (!work())
        clock_.wait(handles(), deadline_);
    if (ended_by_loss_)
        return std::unexpected(lost_error_);
    return {};
}

std::expected<wire::Frame, Error> Bus::one(const wire::Request& request)
{
    Result result;
    (void)exchange({&request, 1}, {&result, 1});
    return result.reply();
}

bool drive(std::span<Bus* const> buses, TimePoint until)
{
    constexpr std::size_t most_handles = 32;
    for (;;) {
        std::array<link::Handle, most_handles> handles;
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
                if (count < handles.size())
                    handles[count++] = handle;
        }
        if (std::ranges::any_of(buses, &Bus::has_news))
            continue;
        if (!open)
            return true;
        link::Clock& clock = buses.front()->clock();
        if (until != TimePoint::max() && clock.now() >= until)
            return false;
        clock.wait(std::span(handles).first(count), deadline);
    }
}

} // namespace sinew::bus
