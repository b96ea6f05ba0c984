#pragma once
#include "sinew/link/descriptor.hpp"

#include <string>

namespace sinew::link {

/// The device end of a pseudo terminal: a simulated device reads and writes here, and any program opens `device()` as
/// its serial port. Programs come and go without a hang-up; what one writes stays to be read after it left.
///
/// A program that claimed the port for itself (TIOCEXCL) and was killed leaves the claim behind, for this end keeps the
/// port open. So every close is watched, and once no program holds its lock (flock, in /proc/locks) the claim is
/// cleared. That happens in `read()`, at the latest 10 ms after the program ended; `handle()` wakes for it.
class PtyMaster final : public ByteLink
{
public:
    /// Raw from the start, so nothing is echoed before a program opens it; a program that sets no rate is seen with
    /// `bit_rate`. `link_failed` when the system has no pseudo terminals left. The clock must outlive it.
    static std::expected<std::unique_ptr<PtyMaster>, Error> open(std::uint32_t bit_rate, const Clock& clock);

    const std::string& device() const { return device_; } ///< "/dev/pts/5"
    std::uint32_t client_bit_rate() const;                ///< as the program that came last set it

    /// Takes less than all when no program reads: like a wire, it does not wait for one (the handle does not wake for
    /// room).
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        return master_.write(bytes);
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override;
    int handle() const override { return watch_.wake.get(); }
    LinkState state() const override { return {.open = master_.is_open(), .bit_rate = client_bit_rate()}; }
    /// `unsupported`: the program at the other end sets it.
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override;

private:
    /// The descriptors beside the master's own.
    struct Watch {
        Fd client; ///< our own hold on the programs' end
        Fd closes; ///< inotify
        Fd again;  ///< timerfd for the second look
        Fd wake;   ///< epoll over master, closes and again
    };
    PtyMaster(Fd master, Watch watch, std::string device, const Clock& clock);
    void clear_claim_left_behind();

    Descriptor master_;
    Watch watch_;
    std::string device_;
};

} // namespace sinew::link
