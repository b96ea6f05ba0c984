#pragma once
#include "sinew/base/time.hpp"

#include <cstdint>
#include <random>

namespace sinew::sim {

/// What goes wrong on a wire, as probabilities from 0 to 1.
///
/// On a serial wire bytes are hit one by one as they are handed to the wire, those of the host and those of replies. On
/// CAN frames are hit one by one: a flipped bit destroys the frame, an error frame follows and the frame is sent again;
/// a dropped one is heard by nobody; an added one is sent twice.
struct WireFaults {
    double flip_bit = 0.0;    ///< one bit of a byte
    double drop_byte = 0.0;   ///< a byte does not come
    double add_byte = 0.0;    ///< a byte of noise comes behind a byte
    double delay_reply = 0.0; ///< a reply comes late by `reply_delay`
    Duration reply_delay{};

    bool hits_bytes() const { return flip_bit > 0.0 || drop_byte > 0.0 || add_byte > 0.0; }
};

/// The chance behind all faults of one wire. The same seed and the same traffic give the same faults on every platform:
/// what cannot happen is not drawn for, and no distribution of the standard library is used.
class Dice
{
public:
    void seed(std::uint64_t value) { engine_.seed(value); }
    bool falls(double probability)
    {
        return probability > 0.0 && static_cast<double>(engine_() >> 11) * 0x1p-53 < probability;
    }
    /// From 0 to `count` - 1.
    unsigned pick(unsigned count) { return static_cast<unsigned>((engine_() >> 32) * count >> 32); }

private:
    std::mt19937_64 engine_{1};
};

} // namespace sinew::sim
