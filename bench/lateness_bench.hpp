#pragma once
#include "sinew/base/error.hpp"

#include <cstddef>
#include <expected>
#include <string>

namespace sinew::bench {

/// How late something was, in microseconds.
struct Lateness {
    double median_us = 0.0;
    double p99_us = 0.0;
    double most_us = 0.0;
};

/// Answers of a world in real time behind pseudo terminals, beside a thread that only waits for as long as each answer
/// ought to take. Both are measured in turn, so that both meet the same machine.
struct LatenessResult {
    std::size_t actuators = 0;
    std::size_t answers = 0;
    std::size_t missing = 0; ///< not there after a second
    std::size_t held_up = 0; ///< what the simulator itself found done more than 10 ms late
    Lateness answer;
    Lateness timer;
    Lateness timer_again;

    double ratio() const { return answer.median_us / timer.median_us; }
    double floor() const { return timer_again.median_us / timer.median_us; }
};

/// The robot file names the world; `answers` requests go round its joints, one every 2 ms.
std::expected<LatenessResult, Error> measure_lateness(const std::string& robot_file, std::size_t answers);

} // namespace sinew::bench
