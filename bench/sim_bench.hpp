#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace sinew::bench {

/// What one operation takes, measured twice, so that the machine's own spread stands beside it.
struct Cost {
    std::string name;
    double ns = 0.0;
    double again_ns = 0.0;

    double floor() const { return again_ns / ns; }
};

/// A world of SAM servos on buses of 250 at most, every bus asked without a pause.
struct WorldResult {
    std::size_t servos = 0;
    double simulated_s = 0.0;
    double wall_s = 0.0;
    double wall_again_s = 0.0; ///< a second world of the same kind; 0: not measured twice
    std::size_t exchanges = 0; ///< answered
    double bytes_per_servo = 0.0;
    double allocations = 0.0; ///< while it ran

    double device_seconds_per_s() const { return static_cast<double>(servos) * simulated_s / wall_s; }
    double times_real_time() const { return simulated_s / wall_s; }
    double floor() const { return wall_again_s / wall_s; }
};

struct SimResult {
    std::vector<Cost> costs;
    std::vector<WorldResult> worlds;
};

/// `hour`: also an hour of 31 servos, which takes most of a minute.
SimResult measure_simulator(bool hour);

} // namespace sinew::bench
