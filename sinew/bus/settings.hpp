#pragma once
#include "sinew/base/time.hpp"

namespace sinew::bus {

/// How patient and how wary a bus is. Time-outs are bits on the wire both ways + the device's response time + a margin
/// that is measured on the link; these are its bounds.
struct Settings {
    Duration margin_at_first = std::chrono::milliseconds(30); ///< until answers have been measured: a slow USB adapter
    Duration margin_least = std::chrono::milliseconds(5);     ///< what a host that schedules fairly may take
    Duration margin_most = std::chrono::milliseconds(120);    ///< however slow the answers were
    /// The latest that an answer can come after its time-out; no family has sequence numbers, so lateness needs a
    /// bound.
    Duration late_max = std::chrono::milliseconds(50);
    int read_retries = 1;
    /// Of commands whose repetition changes nothing: targets and settings, never relative moves or what writes flash.
    /// Off, because a command that is not answered may have been carried out, and its second run starts later.
    int command_retries = 0;
    /// Reads whose answers are bare (SAM) go out twice and are returned only if both answers agree (`agree.hpp`).
    /// Halves the rate, and makes a wrong value as unlikely as two like faults in a row (docs/guide/residual-risk.md).
    bool double_read = false;
    /// Bytes take their time on this line, so what comes earlier than an answer can be is none. Off for a peer behind a
    /// pseudo terminal that answers at once.
    bool paced = true;
};

} // namespace sinew::bus
