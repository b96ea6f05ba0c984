#pragma once
#include "sinew/link/can_ids.hpp"
#include "sinew/link/can_interface.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/descriptor.hpp"
#include "sinew/link/link.hpp"
#include "sinew/link/uri.hpp"

#include <functional>
#include <linux/can.h>
#include <sys/socket.h>
#include <time.h>

namespace sinew::link {

struct SocketCanOptions {
    std::string interface;             ///< "can0"
    std::vector<IdFilter> ids{};       ///< what is heard; empty: all standard identifiers
    std::uint32_t stated_bit_rate = 0; ///< must be that of the interface; where that tells none (vcan), it is believed
};

/// A CAN interface of Linux (SocketCAN, CAN_RAW): `can0`, `vcan0`, a kernel `slcan0`. Classic frames with standard
/// identifiers; the kernel drops all others before they get here. Other programs on the interface hear what is written
/// here, and the other way round; own frames do not come back.
///
/// The kernel holds few frames of this link at a time (its send buffer is the smallest there is), so a program does not
/// fill the queue of the interface (txqueuelen, 10 as a rule) against others, and the descriptor wakes for room. When
/// others have filled it (ENOBUFS), `write` takes nothing until a frame of ours has gone out, or `retry_after`.
///
/// Error frames are counted, shown to whoever asks (`set_error_tap`) and never returned. Bus-off makes the next `read`
/// fail, once, with `link_failed`; the link stays open, for the interface may restart. When the interface goes down or
/// is removed the link is lost at once.
class SocketCanLink final : public CanLink
{
public:
    struct Counters {
        std::uint64_t error_frames = 0;     ///< of any kind, all of the following among them
        std::uint64_t bus_offs = 0;         ///< the controller fell silent
        std::uint64_t restarts = 0;         ///< and came back
        std::uint64_t not_acknowledged = 0; ///< nobody on the bus heard a frame
        std::uint64_t bus_errors = 0;       ///< of bits, stuffing, form or CRC, where the driver reports them
        std::uint64_t overruns = 0;         ///< the controller lost frames, for the driver did not fetch them in time
        std::uint64_t queue_full = 0;       ///< how often the interface took no more (ENOBUFS)
        std::uint64_t lost = 0;             ///< frames that came while this program did not read
    };

    /// `link_not_found` where there is no such interface, with those there are; `link_failed` with the command that
    /// helps where it is down, runs at another rate than stated, or the kernel has no CAN. The clock must outlive the
    /// link.
    static std::expected<std::unique_ptr<SocketCanLink>, Error> open(const SocketCanOptions& options,
                                                                     const Clock& clock);

    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override;
    /// One frame a call, with the time at which the kernel got it from the driver.
    std::expected<Arrival, Error> read(std::span<wire::Frame> into) override;
    /// Another descriptor while the interface is full: ask before every wait.
    int handle() const override { return is_full_ ? full_wait_.get() : fd_.get(); }
    LinkState state() const override { return {.open = static_cast<bool>(fd_), .bit_rate = bit_rate_}; }
    /// `unsupported`, with the commands that set it, unless it is the rate there is.
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override;

    std::size_t spell(const wire::Frame& frame, std::span<std::uint8_t, longest_spelling> into) const override;

    /// Shows every error frame, as soon as `read` comes to it, with the time at which the kernel got it:
    /// `can_error.hpp` says what it means. An empty function: nobody is shown any.
    using ErrorTap = std::function<void(const wire::Frame& error, TimePoint at)>;
    void set_error_tap(ErrorTap tap) { error_tap_ = std::move(tap); }

    Counters counters() const; ///< asks the kernel for `lost`
    const std::string& interface() const { return interface_; }

    /// How long a full interface is left alone when no frame of ours waits in it.
    static constexpr Duration retry_after = std::chrono::milliseconds{1};

private:
    static constexpr std::size_t batch = 16;

    SocketCanLink(Fd fd, const CanInterface& interface, const Clock& clock);
    std::expected<void, Error> settle(const SocketCanOptions& options, const CanInterface& interface);
    std::expected<std::size_t, Error> receive();
    TimePoint arrival_of(const msghdr& message, TimePoint now, Duration real_now) const;
    bool note_error(const can_frame& frame, TimePoint at);
    void set_full(bool full);
    std::unexpected<Error> hang_up(int problem);
    std::unexpected<Error> lost() const;

    struct Heard {
        can_frame frame;
        alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control;
        iovec place;
        TimePoint at;
    };

    Fd fd_;
    std::string interface_;
    std::string bring_up_; ///< the command
    const Clock* clock_;
    std::uint32_t bit_rate_;
    std::uint32_t restart_ms_;
    int lost_by_ = 0; ///< errno
    Counters counters_;
    ErrorTap error_tap_;

    std::array<Heard, batch> heard_{};
    std::array<mmsghdr, batch> messages_{};
    std::size_t next_ = 0, count_ = 0; ///< of `heard_`
    bool is_drained_ = false;          ///< the last receive fetched all there was
    TimePoint drained_at_{};

    bool is_full_ = false;
    TimePoint retry_at_{};
    Fd retry_timer_;
    Fd full_wait_; ///< epoll over the socket, for input alone, and the timer
};

/// `can:INTERFACE?bitrate=RATE&ids=LIST`.
std::expected<std::unique_ptr<CanLink>, Error> open_socketcan(const Uri& uri, Clock& clock);

} // namespace sinew::link
