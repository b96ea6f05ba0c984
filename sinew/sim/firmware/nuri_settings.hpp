#pragma once
#include <cstdint>

/// What a Nuri remembers. Defaults in braces in the document are those here; gains are product dependent (N19), so they
/// are GUESSES.
namespace sinew::sim {

struct NuriController {
    std::uint8_t kp = 100;
    std::uint8_t ki = 10;
    std::uint8_t kd = 10;
    std::uint8_t rated_current = 1; ///< 0.1 A
};

/// GUESS (N24): what the factory reset restores.
struct NuriSettings {
    std::uint8_t id = 0;
    std::uint32_t bit_rate = 9600;
    std::uint8_t response_time = 1;  ///< 100 µs
    std::uint16_t gear_ratio = 10;   ///< 0.1
    std::uint16_t rated_speed = 60;  ///< MC line
    std::uint16_t resolution = 4096; ///< MC line
    bool on = true;
    bool relative = false;
    bool inverted = false;
    NuriController position;
    NuriController speed;
};

} // namespace sinew::sim
