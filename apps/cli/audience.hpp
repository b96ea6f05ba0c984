#pragma once
#include "sinew/family/families.hpp"

#include <vector>

namespace sinew::cli {

/// Everybody who may hear what a scan sends on a serial line: devices of each family, set to each of their bit rates,
/// with clocks that are a little off. At another rate other bytes arrive, and there are probes out of which a SAM hears
/// a position command or a write to its flash. Whoever sends asks first.
class Audience
{
public:
    Audience();

    /// Whether nobody can take anything but a read out of this frame: neither somebody who was silent before nor
    /// somebody who still remembers the bytes that came earlier. A bit rate of 0 is not known: then as if it were sent
    /// at every rate.
    bool harmless(const wire::Frame& frame, std::uint32_t bit_rate) const;
    /// The frame was sent.
    void hear(const wire::Frame& frame, std::uint32_t bit_rate);

private:
    struct Listener {
        const Family* family = nullptr;
        double bit_rate = 0.0;
        bool takes_broken_bytes = false; ///< also delivers a byte without its stop bit
        std::vector<std::uint8_t> remembers{};
    };

    std::vector<Listener> listeners_;
};

/// What a UART at `heard_bps` receives when these bytes are sent back to back at `sent_bps` on a silent line: it waits
/// for a fall, looks whether the middle of the start bit is low, and samples every bit in its middle.
std::vector<std::uint8_t> hear_at(std::span<const std::uint8_t> bytes, double sent_bps, double heard_bps,
                                  bool takes_broken_bytes);

} // namespace sinew::cli
