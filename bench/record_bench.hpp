#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>

namespace sinew::bench {

/// What it costs to record a robot of 16 joints at 1 kHz: a state and a command of every joint, and two frames for
/// each, in every cycle.
struct RecordResult {
    double simulated_min = 0.0;
    double push_s_per_min = 0.0;  ///< processor time of the robot's thread, for a minute of data
    double write_s_per_min = 0.0; ///< of the thread that formats and writes
    double share = 0.0;           ///< of one core, both together
    double push_ns = 0.0;         ///< one push
    double bytes_per_min = 0.0;
    std::uint64_t messages = 0;
    std::uint64_t dropped = 0;
    double allocations = 0.0; ///< of all pushes
};

/// `minutes` of data, recorded as fast as the machine does it, into a file that is removed afterwards.
std::expected<RecordResult, Error> measure_recording(double minutes);

} // namespace sinew::bench
