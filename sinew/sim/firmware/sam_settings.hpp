#pragma once
#include "sinew/family/sam/messages.hpp"
#include "sinew/family/sam/models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

/// What a SAM remembers. Factory values that the manual does not print (S78) are GUESSES and stand here.
namespace sinew::sim {

/// A range of positions in 1 … 254 around 127.
struct SamBoundary {
    std::uint8_t lower = 1;
    std::uint8_t upper = 254;
};

struct SamGains {
    std::uint8_t p = 100;
    std::uint8_t i = 0;
    std::uint8_t d = 100;
};

/// Flash.
struct SamSettings {
    std::uint8_t id = 0;
    std::uint32_t bit_rate = 1'500'000;
    SamGains gains;
    std::uint16_t overload = 4095; ///< 12-bit AD; the quick commands see its upper 8 bits (S60)
    SamBoundary quick_boundary;
    SamBoundary standard_boundary;
    int response_level = 0;
    bool reverse = false;
    std::uint16_t avg_torque = 2000;
    std::uint8_t motion_count = 0;
    std::array<wire::Pair, 8> motion{};
};

/// Gone at power-off.
struct SamRegisters {
    SamGains gains; ///< in use: the flash values, until run-time values come (A.9)
    // Only the code listing names these four (S36); 0 is no limit. GUESS: units of current speed, AVG torque and
    // current acceleration.
    std::uint16_t ctrl_speed = 0;
    std::uint16_t ctrl_torque = 0;
    std::uint16_t ctrl_accel = 0;
    std::uint16_t ctrl_decel = 0;
    sam::ExternalPort port;
};

/// Stores a boundary that came in quick (`quick`) or standard coordinates as the device is built (S61).
inline void store_boundary(SamSettings& settings, const sam::Spec& spec, bool quick, SamBoundary boundary)
{
    (quick ? settings.quick_boundary : settings.standard_boundary) = boundary;
    SamBoundary& other = quick ? settings.standard_boundary : settings.quick_boundary;
    if (spec.device.boundary_storage == sam::BoundaryStorage::shared_raw)
        other = boundary;
    if (spec.device.boundary_storage != sam::BoundaryStorage::shared_angle)
        return;
    const double from = quick ? spec.model->quick.deg_per_unit : spec.model->boundary_deg_per_unit;
    const double to = quick ? spec.model->boundary_deg_per_unit : spec.model->quick.deg_per_unit;
    const auto convert = [&](std::uint8_t raw) {
        const double there = (raw - sam::boundary_centre) * from / to + sam::boundary_centre;
        return static_cast<std::uint8_t>(std::clamp(std::lround(there), 1L, 254L));
    };
    other = {convert(boundary.lower), convert(boundary.upper)};
}

} // namespace sinew::sim
