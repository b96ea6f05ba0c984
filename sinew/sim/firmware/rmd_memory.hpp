#pragma once
#include "sinew/family/rmd/lines.hpp"
#include "sinew/family/rmd/models.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

/// What an RMD remembers. No document prints factory values, and none the units of the parameters (R17): those here are
/// GUESSES.
namespace sinew::sim {

// Bits of the error state; lines of two have only the outer ones (L567-574, field notes 1).
inline constexpr std::uint8_t rmd_low_voltage = 1U << 0;
inline constexpr std::uint8_t rmd_high_voltage = 1U << 1;
inline constexpr std::uint8_t rmd_over_temperature = 1U << 3;

/// One copy of the memory, RAM or ROM.
struct RmdMemory {
    std::array<std::uint64_t, std::size(rmd::parameters)> parameters{}; ///< data bytes 2 to 7
    rmd::gyems::Pid pid{};
    std::uint16_t encoder_offset = 0;

    std::uint64_t& parameter(rmd::ParameterId id) { return parameters[place(id)]; }
    std::uint64_t parameter(rmd::ParameterId id) const { return parameters[place(id)]; }

    static std::size_t place(rmd::ParameterId id)
    {
        return static_cast<std::size_t>(id) - static_cast<std::size_t>(rmd::ParameterId::angle_pid);
    }
};

/// The bits of `value` that the parameter has.
constexpr std::uint64_t parameter_bits(rmd::ParameterId id, std::uint64_t value)
{
    unsigned bytes = 0;
    for (const auto& variant : rmd::parameters)
        if (variant.selector == static_cast<std::int64_t>(id))
            for (const auto& field : variant.fields)
                bytes += field.bytes;
    return value & ((std::uint64_t{1} << (8 * bytes)) - 1);
}

/// As delivered: the limits of the setting tool as the options have them, in the units of the commands they limit.
inline RmdMemory delivered_memory(const rmd::Spec& spec, double velocity_max_dps, int full_current_raw)
{
    using rmd::ParameterId;
    const auto pid = [](std::uint64_t kp, std::uint64_t ki, std::uint64_t kd) { return kp | ki << 16 | kd << 32; };
    RmdMemory out;
    out.parameter(ParameterId::angle_pid) = pid(100, 100, 0);
    out.parameter(ParameterId::speed_pid) = pid(50, 40, 0);
    out.parameter(ParameterId::current_pid) = pid(50, 50, 0);
    out.parameter(ParameterId::max_torque_current) = static_cast<std::uint64_t>(full_current_raw);
    out.parameter(ParameterId::max_speed) = static_cast<std::uint64_t>(velocity_max_dps * 100.0);
    const auto angle = static_cast<std::uint64_t>(spec.device.max_angle_deg * 100.0);
    out.parameter(ParameterId::max_angle_low) = angle & 0xFFFF'FFFF;
    out.parameter(ParameterId::max_angle_high) = angle >> 32;
    out.pid = {100, 100, 50, 40, 50, 50};
    return out;
}

} // namespace sinew::sim
