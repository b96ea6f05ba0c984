#pragma once
#include "sinew/base/time.hpp"

namespace sinew::bus {

/// How patient a bus is. Time-outs are bits on the wire both ways + the device's response time + a margin that is
/// measured on the link; these are its bounds.
struct Settings {
    Duration margin_at_first = std::chrono::milliseconds(30); ///< until answers have been measured: a slow USB adapter
    Duration margin_least = std::chrono::milliseconds(5);     ///< what a host that schedules fairly may take
    /// The latest that an answer can come after its time-out; no family has sequence numbers, so lateness needs a
    /// bound.
    Duration late_max = std::chrono::milliseconds(50);
    int read_retries = 1; ///< commands are never repeated
};

} // namespace sinew::bus
