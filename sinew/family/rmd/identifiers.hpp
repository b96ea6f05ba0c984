#pragma once
#include <cstdint>

/// Where an RMD listens and answers on CAN (L7-17, L193-201).
namespace sinew::rmd {

inline constexpr std::uint32_t identifier_base = 0x140;        ///< + id
inline constexpr std::uint32_t multi_motor_identifier = 0x280; ///< R24: the motors 1 to 4

} // namespace sinew::rmd
