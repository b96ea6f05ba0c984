#pragma once
#include "sinew/link/clock.hpp"
#include "sinew/link/reopen.hpp"
#include "sinew/link/slcan.hpp"
#include "sinew/link/uri.hpp"

#include <functional>
#include <string>
#include <vector>

/// How the bus behind an SLCAN adapter is opened: at the start by `SlcanLink::open`, after a loss step by step.
namespace sinew::link {

/// Opens the bus on an adapter that was lost, without waiting: a step opens the port and sends all that
/// `SlcanLink::open` sends, in one, as slcand of can-utils does; a later one looks what the adapter said to it.
class SlcanReopening
{
public:
    using OpenPort = std::function<std::expected<std::unique_ptr<ByteLink>, Error>()>;

    /// The clock must outlive it. A rate without a code: every step is `unsupported`.
    SlcanReopening(OpenPort open_port, std::uint32_t bit_rate, const Clock& clock)
        : open_port_(std::move(open_port)), bit_rate_(bit_rate), clock_(&clock)
    {
    }
    /// The link once the adapter has acknowledged everything or was silent for 0.1 s; until then why it is not there.
    /// After a refusal, a loss or an adapter that takes no bytes the next step begins anew.
    std::expected<std::unique_ptr<CanLink>, Error> step();

private:
    std::expected<void, Error> begin();
    std::expected<void, Error> send();
    std::expected<void, Error> hear();
    bool is_refused() const;

    OpenPort open_port_;
    std::uint32_t bit_rate_;
    const Clock* clock_;
    std::unique_ptr<ByteLink> adapter_; ///< that was told to open; none: to be begun
    std::string unsent_;
    TimePoint begun_{};
    slcan::Reader reader_;
    std::vector<bool> answers_; ///< whether each was an acknowledgement
};

/// `slcan:DEVICE?bitrate=RATE&baud=RATE`: the CAN bit rate (1000000 where none is given) and that of the serial port
/// (115200; adapters that are USB devices themselves take any).
std::expected<std::unique_ptr<CanLink>, Error> open_slcan(const Uri& uri, Clock& clock);

/// Opens it again after it was lost; a try is a step of `SlcanReopening`. The clock must outlive it.
Reopen reopen_slcan(const Uri& uri, Clock& clock);

/// What cannot be done, for this room only.
std::unexpected<Error> refuse_slcan_rate(std::uint32_t bit_rate);
std::unexpected<Error> slcan_takes_no_bytes();

} // namespace sinew::link
