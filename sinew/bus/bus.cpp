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
    if (id >= 0 && id < 256)
        devices_[static_cast<std::size_t>(id)] = device;
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
    stop_.store(false);
}

void Bus::start(std::span<const wire::Request> requests, std::span<Result> results)
{
    conversation_.begin(requests, results);
    ended_by_loss_ = std::exchange(untold_, false);
    if (ended_by_loss_)
        conversation_.abandon(lost_error_, clock_.now());
}

std::span<const link::Handle> Bus::handles()
{
    const int fd = std::visit([](const auto& l) { return l->handle(); }, link_);
    handles_ = {link::Handle{fd, pending_ != nullptr}, link::Handle{stop_event_, false}};
    return handles_;
}

void Bus::end_with(const Error& error)
{
    pending_ = nullptr;
    written_ = 0;
    // A link that stays open, such as an SLCAN adapter that refused one frame, serves the next exchange.
    if (!link_state().open) {
        lost_ = true;
        lost_error_ = error;
        ++losses_;
        next_try_ = clock_.now();
        ended_by_loss_ = conversation_.busy();
        untold_ = !ended_by_loss_;
    }
    conversation_.abandon(error, clock_.now());
}

void Bus::read_link()
{
    if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_)) {
        std::array<std::uint8_t, 256> buffer;
        for (;;) {
            const auto got = (*bytes)->read(buffer);
            if (!got)
                return end_with(got.error());
            if (got->count == 0)
                return;
            const auto part = std::span(buffer).first(got->count);
            if (tap_)
                tap_({got->at, wire::Direction::reply, part});
            conversation_.received(part, got->at);
        }
    }
    std::array<wire::Frame, 16> frames;
    for (;;) {
        const auto got = std::get<std::unique_ptr<link::CanLink>>(link_)->read(frames);
        if (!got)
            return end_with(got.error());
        if (got->count == 0)
            return;
        for (const auto& frame : std::span(frames).first(got->count)) {
            if (tap_)
                tap_({got->at, wire::Direction::reply, frame.bytes(), frame.can_id});
            conversation_.received(frame, got->at);
        }
    }
}

bool Bus::write_pending()
{
    const bool first = written_ == 0;
    std::expected<std::size_t, Error> wrote;
    if (auto* bytes = std::get_if<std::unique_ptr<link::ByteLink>>(&link_)) {
        wrote = (*bytes)->write(pending_->bytes().subspan(written_));
    } else {
        wrote = std::get<std::unique_ptr<link::CanLink>>(link_)->write({pending_, 1});
        if (wrote)
            *wrote *= pending_->size;
    }
    if (!wrote) {
        end_with(wrote.error());
        return true;
    }
    if (tap_ && first && *wrote > 0)
        tap_({clock_.now(), wire::Direction::request, pending_->bytes(), pending_->can_id});
    written_ += *wrote;
    if (written_ < pending_->size)
        return false;
    pending_ = nullptr;
    written_ = 0;
    conversation_.transmitted(clock_.now());
    return true;
}

bool Bus::work()
{
    if (lost_)
        try_to_reopen();
    else
        read_link();
    for (;;) {
        if (lost_) {
            ended_by_loss_ = ended_by_loss_ || conversation_.busy();
            conversation_.abandon(lost_error_, clock_.now());
            return true;
        }
        // A frame that has begun is finished: half a frame would garble the stop that follows.
        if (stop_.load() && written_ == 0) {
            pending_ = nullptr;
            conversation_.abandon({.code = Errc::stopped}, clock_.now());
            return true;
        }
        if (pending_ != nullptr && !write_pending()) {
            if (clock_.now() < write_deadline_) {
                deadline_ = write_deadline_;
                return false;
            }
            Error stuck{.code = Errc::link_failed};
            stuck.detail = "the port takes no bytes any more; is its other end stuck?";
            end_with(stuck);
        } else if (pending_ == nullptr && !begin_next()) {
            return !conversation_.busy();
        }
    }
}

bool Bus::begin_next()
{
    const auto next = conversation_.next(clock_.now());
    deadline_ = next.deadline;
    pending_ = next.transmit;
    write_deadline_ = clock_.now() + write_patience;
    return pending_ != nullptr;
}

std::expected<void, Error> Bus::exchange(std::span<const wire::Request> requests, std::span<Result> results)
{
    start(requests, results);
    Bus* const self = this;
    drive({&self, 1});
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
            if (bus->work())
                continue;
            open = true;
            deadline = std::min(deadline, bus->deadline());
            for (const auto& handle : bus->handles())
                if (count < handles.size())
                    handles[count++] = handle;
        }
        if (!open)
            return true;
        link::Clock& clock = buses.front()->clock();
        if (clock.now() >= until)
            return false;
        clock.wait(std::span(handles).first(count), deadline);
    }
}

} // namespace sinew::bus
