#include "sinew/link/socketcan.hpp"

#include "sinew/link/can_frames.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>

namespace sinew::link {
namespace {

constexpr std::uint32_t standard_only = CAN_EFF_FLAG | CAN_RTR_FLAG; // in a mask: neither of the two
static_assert(SocketCanLink::retry_after < std::chrono::seconds{1});

Duration real_time()
{
    timespec t{};
    ::clock_gettime(CLOCK_REALTIME, &t);
    return std::chrono::seconds{t.tv_sec} + std::chrono::nanoseconds{t.tv_nsec};
}

template <class T>
bool set(int fd, int level, int option, const T& value)
{
    return ::setsockopt(fd, level, option, &value, sizeof value) == 0;
}

std::unexpected<Error> refused(const std::string& interface)
{
    return fail(Errc::link_failed, fmt::format("cannot open {}: {}", interface, std::strerror(errno)));
}

std::expected<Fd, Error> raw_socket()
{
    Fd fd{::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW)};
    if (fd)
        return fd;
    if (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT)
        return fail(Errc::link_failed,
                    "this kernel has no CAN: try 'modprobe can-raw'; kernels of cloud machines are built without it. "
                    "An adapter that speaks SLCAN needs none: slcan:/dev/ttyACM0?bitrate=1000000");
    return fail(Errc::link_failed, fmt::format("cannot open a CAN socket: {}", std::strerror(errno)));
}

std::expected<std::uint32_t, Error> bit_rate_of(const CanInterface& interface, std::uint32_t stated)
{
    if (stated == 0 || interface.bit_rate == stated)
        return interface.bit_rate;
    if (interface.bit_rate == 0)
        return stated;
    return fail(Errc::link_failed,
                fmt::format("{0} runs at {1} bit/s, not at {2}: 'ip link set {0} down', then 'ip link set {0} up type "
                            "can bitrate {2}'",
                            interface.name, interface.bit_rate, stated));
}

can_frame to_can_frame(const wire::Frame& frame)
{
    can_frame out{};
    out.can_id = frame.can_id;
    out.len = frame.size;
    std::ranges::copy(frame.bytes(), out.data);
    return out;
}

wire::Frame to_frame(const can_frame& frame, std::uint32_t mask)
{
    wire::Frame out{.can_id = frame.can_id & mask, .size = std::min<std::uint8_t>(frame.len, CAN_MAX_DLEN)};
    std::copy_n(frame.data, out.size, out.data.begin());
    return out;
}

} // namespace

std::expected<std::unique_ptr<SocketCanLink>, Error> SocketCanLink::open(const SocketCanOptions& options,
                                                                         const Clock& clock)
{
    auto fd = raw_socket();
    if (!fd)
        return std::unexpected(std::move(fd.error()));
    const auto interface = can_interface(options.interface);
    if (!interface)
        return std::unexpected(interface.error());
    if (!interface->is_up)
        return fail(Errc::link_failed,
                    fmt::format("{} is down: '{}' brings it up", interface->name, how_to_bring_up(*interface)));
    std::unique_ptr<SocketCanLink> link(new SocketCanLink(std::move(*fd), *interface, clock));
    if (const auto settled = link->settle(options, *interface); !settled)
        return std::unexpected(settled.error());
    return link;
}

SocketCanLink::SocketCanLink(Fd fd, const CanInterface& interface, const Clock& clock)
    : fd_(std::move(fd)), interface_(interface.name), bring_up_(how_to_bring_up(interface)), clock_(&clock),
      bit_rate_(interface.bit_rate), restart_ms_(interface.restart_ms), drained_at_(clock.now()),
      retry_timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)),
      full_wait_(::epoll_create1(EPOLL_CLOEXEC))
{
    for (std::size_t i = 0; i < batch; ++i) {
        heard_[i].place = {.iov_base = &heard_[i].frame, .iov_len = sizeof(can_frame)};
        messages_[i].msg_hdr.msg_iov = &heard_[i].place;
        messages_[i].msg_hdr.msg_iovlen = 1;
        messages_[i].msg_hdr.msg_control = heard_[i].control.data();
    }
}

std::expected<void, Error> SocketCanLink::settle(const SocketCanOptions& options, const CanInterface& interface)
{
    const auto bit_rate = bit_rate_of(interface, options.stated_bit_rate);
    if (!bit_rate)
        return std::unexpected(bit_rate.error());
    bit_rate_ = *bit_rate;

    std::vector<can_filter> filters;
    for (const IdFilter& ids : options.ids)
        filters.push_back({.can_id = ids.id, .can_mask = ids.mask | standard_only});
    if (filters.empty())
        filters.push_back({.can_id = 0, .can_mask = standard_only});
    const bool is_set = ::setsockopt(fd_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                                     static_cast<socklen_t>(filters.size() * sizeof filters[0])) == 0 &&
                        set(fd_.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}) &&
                        set(fd_.get(), SOL_SOCKET, SO_TIMESTAMPNS, 1) && set(fd_.get(), SOL_SOCKET, SO_SNDBUF, 0);
    epoll_event input{.events = EPOLLIN, .data = {}};
    const bool is_watched = ::epoll_ctl(full_wait_.get(), EPOLL_CTL_ADD, fd_.get(), &input) == 0 &&
                            ::epoll_ctl(full_wait_.get(), EPOLL_CTL_ADD, retry_timer_.get(), &input) == 0;
    const sockaddr_can address{.can_family = AF_CAN, .can_ifindex = interface.index};
    if (!is_set || !is_watched || ::bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return refused(interface_);
    return {};
}

std::size_t SocketCanLink::spell(const wire::Frame& frame, std::span<std::uint8_t, longest_spelling> into) const
{
    const can_frame out = to_can_frame(frame);
    static_assert(sizeof out <= longest_spelling);
    std::memcpy(into.data(), &out, sizeof out);
    return sizeof out;
}

std::expected<std::size_t, Error> SocketCanLink::write(std::span<const wire::Frame> frames)
{
    if (!fd_)
        return lost();
    if (const auto fine = check_can_frames(frames); !fine)
        return std::unexpected(fine.error());
    if (is_full_ && clock_->now() < retry_at_)
        return 0;
    std::size_t taken = 0;
    while (taken < frames.size()) {
        std::array<can_frame, batch> out{};
        std::array<iovec, batch> places{};
        std::array<mmsghdr, batch> messages{};
        const std::size_t count = std::min(batch, frames.size() - taken);
        for (std::size_t i = 0; i < count; ++i) {
            out[i] = to_can_frame(frames[taken + i]);
            places[i] = {.iov_base = &out[i], .iov_len = sizeof out[i]};
            messages[i].msg_hdr.msg_iov = &places[i];
            messages[i].msg_hdr.msg_iovlen = 1;
        }
        const int sent = ::sendmmsg(fd_.get(), messages.data(), static_cast<unsigned>(count), 0);
        if (sent > 0) {
            taken += static_cast<std::size_t>(sent);
            continue;
        }
        if (errno == EINTR)
            continue;
        if (errno == ENOBUFS) {
            ++counters_.queue_full;
            set_full(true);
            return taken;
        }
        if (errno == EAGAIN || errno == EWOULDBLOCK)
            break; // the socket itself wakes for room
        return hang_up(errno);
    }
    if (is_full_)
        set_full(false);
    return taken;
}

/// Full: own frames come back as confirmations (MSG_CONFIRM), for each one that leaves makes room.
void SocketCanLink::set_full(bool full)
{
    if (is_full_ != full)
        set(fd_.get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, full ? 1 : 0);
    is_full_ = full;
    retry_at_ = clock_->now() + retry_after;
    const itimerspec once{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_nsec = full ? retry_after.count() : 0}};
    ::timerfd_settime(retry_timer_.get(), 0, &once, nullptr);
}

std::expected<Arrival, Error> SocketCanLink::read(std::span<wire::Frame> into)
{
    if (!fd_)
        return lost();
    while (!into.empty()) {
        if (next_ == count_) {
            if (is_drained_) { // a moment ago; what came since wakes the next wait
                is_drained_ = false;
                break;
            }
            const auto received = receive();
            if (!received)
                return std::unexpected(received.error());
            if (*received == 0)
                break;
        }
        const Heard& heard = heard_[next_];
        const bool is_confirmation = (messages_[next_++].msg_hdr.msg_flags & MSG_CONFIRM) != 0;
        if (is_confirmation) {
            retry_at_ = TimePoint{};
        } else if ((heard.frame.can_id & CAN_ERR_FLAG) == 0) {
            into[0] = to_frame(heard.frame, CAN_SFF_MASK);
            return Arrival{.count = 1, .at = heard.at, .more = true};
        } else if (note_error(heard.frame, heard.at)) {
            return fail(Errc::link_failed,
                        fmt::format("{0} is bus-off: its controller saw too many errors and fell silent. Check bit "
                                    "rate, termination and wiring; {1}",
                                    interface_,
                                    restart_ms_ != 0 ? fmt::format("it restarts by itself after {} ms", restart_ms_)
                                                     : fmt::format("'ip link set {} type can restart' starts it again",
                                                                   interface_)));
        }
    }
    return Arrival{.count = 0, .at = clock_->now()};
}

std::expected<std::size_t, Error> SocketCanLink::receive()
{
    for (mmsghdr& message : messages_)
        message.msg_hdr.msg_controllen = sizeof(Heard::control);
    int count = 0;
    do
        count = ::recvmmsg(fd_.get(), messages_.data(), batch, MSG_DONTWAIT, nullptr);
    while (count < 0 && errno == EINTR);
    if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK)
        return hang_up(errno);
    next_ = 0;
    count_ = count < 0 ? 0 : static_cast<std::size_t>(count);
    const TimePoint now = clock_->now();
    const Duration real_now = real_time();
    for (std::size_t i = 0; i < count_; ++i)
        heard_[i].at = arrival_of(messages_[i].msg_hdr, now, real_now);
    // An empty queue is known to be empty; a short batch saves the next look.
    is_drained_ = count_ != 0 && count_ < batch;
    if (count_ < batch)
        drained_at_ = now;
    return count_;
}

/// The kernel stamps by the wall clock, which may be set at any moment: what counts is how long ago that was, and never
/// before the queue was last seen empty.
TimePoint SocketCanLink::arrival_of(const msghdr& message, TimePoint now, Duration real_now) const
{
    for (const cmsghdr* control = CMSG_FIRSTHDR(&message); control != nullptr;
         control = CMSG_NXTHDR(const_cast<msghdr*>(&message), const_cast<cmsghdr*>(control))) {
        if (control->cmsg_level != SOL_SOCKET || control->cmsg_type != SCM_TIMESTAMPNS)
            continue;
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(control), sizeof stamp);
        const Duration age = real_now - std::chrono::seconds{stamp.tv_sec} - std::chrono::nanoseconds{stamp.tv_nsec};
        return std::clamp(now - age, std::min(drained_at_, now), now);
    }
    return now;
}

/// True for a bus-off.
bool SocketCanLink::note_error(const can_frame& frame, TimePoint at)
{
    if (error_tap_)
        error_tap_(to_frame(frame, CAN_ERR_MASK), at);
    const std::uint32_t kind = frame.can_id;
    ++counters_.error_frames;
    counters_.restarts += (kind & CAN_ERR_RESTARTED) != 0 ? 1 : 0;
    counters_.not_acknowledged += (kind & CAN_ERR_ACK) != 0 ? 1 : 0;
    counters_.bus_errors += (kind & (CAN_ERR_PROT | CAN_ERR_BUSERROR)) != 0 ? 1 : 0;
    counters_.overruns += (kind & CAN_ERR_CRTL) != 0 && (frame.data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0 ? 1 : 0;
    const bool is_off = (kind & CAN_ERR_BUSOFF) != 0;
    counters_.bus_offs += is_off ? 1 : 0;
    return is_off;
}

SocketCanLink::Counters SocketCanLink::counters() const
{
    Counters all = counters_;
    std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
    socklen_t size = sizeof memory;
    if (fd_ && ::getsockopt(fd_.get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size) == 0)
        all.lost = memory[SK_MEMINFO_DROPS];
    return all;
}

std::expected<std::uint32_t, Error> SocketCanLink::set_bit_rate(std::uint32_t bit_rate)
{
    if (!fd_)
        return lost();
    if (bit_rate == bit_rate_)
        return bit_rate;
    return fail(Errc::unsupported,
                fmt::format("the bit rate of {0} is set outside: 'ip link set {0} down', then 'ip link set {0} up type "
                            "can bitrate {1}'",
                            interface_, bit_rate));
}

std::unexpected<Error> SocketCanLink::hang_up(int problem)
{
    counters_ = counters(); // the kernel's part goes with the socket
    fd_.close();
    is_full_ = false;
    lost_by_ = problem;
    return lost();
}

std::unexpected<Error> SocketCanLink::lost() const
{
    switch (lost_by_) {
    case ENETDOWN:
        return fail(Errc::link_lost, fmt::format("{} went down; '{}' brings it up again", interface_, bring_up_));
    case ENODEV:
    case ENXIO:
        return fail(Errc::link_lost, fmt::format("{} is gone: its adapter was unplugged or the interface removed; "
                                                 "plug it in again and bring it up with '{}'",
                                                 interface_, bring_up_));
    default:
        return fail(Errc::link_lost, fmt::format("{} was lost: {}", interface_, std::strerror(lost_by_)));
    }
}

std::expected<std::unique_ptr<CanLink>, Error> open_socketcan(const Uri& uri, Clock& clock)
{
    SocketCanOptions options{.interface = uri.target};
    const auto bit_rate = uri.number("bitrate");
    if (!bit_rate)
        return std::unexpected(bit_rate.error());
    options.stated_bit_rate = bit_rate->value_or(0);
    if (const auto ids = uri.option("ids")) {
        auto filters = parse_can_ids(*ids);
        if (!filters)
            return std::unexpected(filters.error());
        options.ids = std::move(*filters);
    }
    return SocketCanLink::open(options, clock);
}

} // namespace sinew::link
