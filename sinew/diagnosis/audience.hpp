#pragma once
#include "sinew/family/families.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
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

/// The levels of a line on which bytes are sent back to back after silence.
struct LineLevels {
    explicit LineLevels(std::span<const std::uint8_t> bytes);

    static constexpr std::size_t bits_per_byte = 10;
    std::array<bool, bits_per_byte * wire::Frame::capacity> high;     ///< of each bit; only `count` of them are set
    std::array<int, bits_per_byte / 2 * wire::Frame::capacity> falls; ///< the bits at whose beginning the level falls
    int count = 0;
    int fall_count = 0;
};

/// What a UART receives of them: it waits for a fall, looks whether the middle of the start bit is low, and samples
/// every bit in its middle. `out` is overwritten.
void hear_at(const LineLevels& line, double sent_bps, const Ear& ear, std::vector<HeardByte>& out);

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
    using Bytes = std::vector<std::uint8_t>;
    /// Some receivers drop a byte without its stop bit, some deliver it.
    struct Listener {
        const Family* family = nullptr;
        Ear ear;
        std::array<Bytes, 2> hears{};     ///< of the last frame: without broken bytes, with them
        std::array<Bytes, 2> remembers{}; ///< of what came before
    };

    struct Verdict {
        bool harm = false;
        std::size_t remembered = 0;
    };
    void listen(const wire::Frame& frame, std::uint32_t bit_rate) const;
    Verdict judge(const Family& family, std::span<const std::uint8_t> bytes, bool silent) const;

    // What was worked out is kept, for most listeners hear the same and a frame is asked about before it is sent.
    mutable std::vector<Listener> listeners_;
    mutable std::optional<std::pair<wire::Frame, std::uint32_t>> listened_;
    mutable std::unordered_map<std::string, Verdict> kept_;
    mutable std::string key_;
};

} // namespace sinew::diagnosis
