#pragma once
#include "sinew/base/time.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace sinew::bus {

/// The weather of one device, or of a whole bus. Counts only grow.
struct Counters {
    std::uint64_t requests = 0; ///< frames sent, retries included
    std::uint64_t replies = 0;
    std::uint64_t timeouts = 0;
    std::uint64_t retries = 0;
    std::uint64_t late = 0;          ///< answers that came when nobody waited for them any more
    std::uint64_t strays = 0;        ///< bytes, on CAN frames, that belong to nothing that was asked
    std::uint64_t bad_checksums = 0; ///< frames whose checksum does not fit, of the device that was asked then
    std::uint64_t echoes = 0;        ///< own requests that came back
    std::uint64_t disagreements = 0; ///< reads of `double_read` whose two answers cannot both be true
    std::uint64_t quarantines = 0;
    /// Round trips by their length: bucket n counts those from 2^n up to 2^(n+1) microseconds.
    static constexpr std::size_t buckets = 20;
    std::array<std::uint32_t, buckets> round_trips{};

    static std::size_t bucket_of(Duration round_trip)
    {
        const auto us = static_cast<std::uint64_t>(round_trip.count() > 0 ? round_trip.count() : 0) / 1000;
        const auto bucket = 63U - static_cast<unsigned>(std::countl_zero(us | 1U));
        return bucket < buckets ? bucket : buckets - 1;
    }
};

} // namespace sinew::bus
