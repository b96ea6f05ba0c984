#pragma once
#include <chrono>
#include <cstddef>
#include <vector>

namespace sinew::bench {

/// What a loop with a period of 1 ms did, in microseconds. Sorted when it is over.
struct LoopRun {
    std::size_t overruns = 0;    ///< cycles that were not over when the next one was due
    std::vector<double> late_us; ///< how much later than due each cycle began
    std::vector<double> took_us; ///< how long after its begin it was over
};

struct LoopResult {
    LoopRun buses;           ///< 4 buses with 8 actuators each, all asked in every cycle
    LoopRun timer;           ///< a thread that only waits for the next cycle
    LoopRun timer_again;     ///< the same
    std::size_t missing = 0; ///< answers that did not come
};

/// Runs the three by turns, a second each, until each has run for `time`, so that all meet the same machine. The buses
/// are sockets that stand in for CAN, each with a device process of its own.
LoopResult measure_loop(std::chrono::seconds time);

void print(const LoopResult& loop);

} // namespace sinew::bench
