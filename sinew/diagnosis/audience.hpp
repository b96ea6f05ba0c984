#pragma once
#include "sinew/family/families.hpp"

#include <array>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace sinew::diagnosis {

/// How somebody listens to a serial line.
struct Ear {
    double bit_rate = 0.0;
    double sampling_shift = 0.0; ///< how much later than in its middle a bit is sampled, in bits
};

struct HeardByte {
    std::uint8_t value = 0;
    bool broken = false; ///< its stop bit was missing
};

/// What a UART receives when these bytes are sent back to back at `sent_bps` on a silent line: it waits for a fall,
/// looks whether the middle of the start bit is low, and samples every bit in its middle.
std::vector<HeardByte> hear_at(std::span<const std::uint8_t> bytes, double sent_bps, const Ear& ear);

/// Everybody who may hear what a scan sends on a serial line: devices of each family, set to each of their bit rates,
/// with clocks that are a little off and bits that are sampled a little early or late. At another rate other bytes
/// arrive, and there are probes out of which a SAM hears a position command or a write to its flash. Whoever sends asks
/// first. One thread.
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
        Ear ear;
        std::array<std::vector<std::uint8_t>, 2> remembers{}; ///< without broken bytes, with them
    };

    struct Verdict {
        bool harm = false;
        std::size_t remembered = 0;
    };
    Verdict judge(const Family& family, std::span<const std::uint8_t> bytes, bool silent) const;

    std::vector<Listener> listeners_;
    mutable std::unordered_map<std::string, Verdict> kept_;
};

} // namespace sinew::diagnosis
