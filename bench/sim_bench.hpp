#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace sinew::bench {

/// A world of SAM servos on buses of 250 at most, every bus asked without a pause.
struct WorldResult {
    std::size_t servos = 0;
    double simulated_s = 0.0;
    double wall_s = 0.0;
    std::size_t exchanges = 0; ///< answered
    double bytes_per_servo = 0.0;
    double allocations = 0.0; ///< while it ran

    double device_seconds_per_s() const { return static_cast<double>(servos) * simulated_s / wall_s; }
    double times_real_time() const { return simulated_s / wall_s; }
};

struct SimResult {
    double step_ns = 0.0;       ///< of a plant that turns
    double step_again_ns = 0.0; ///< the same, measured a second time
    double resting_tick_ns = 0.0;
    double exchange_ns = 0.0; ///< firmware and wire, 31 devices on the wire
    double exchange_again_ns = 0.0;
    std::vector<WorldResult> worlds;
};

/// `hour`: also an hour of 31 servos, which takes most of a minute.
SimResult measure_simulator(bool hour);

} // namespace sinew::bench
