#pragma once
#include <numbers>

/// Conversions for the edge of the library: inside it everything is SI.
namespace sinew::units {

inline constexpr double rad_per_deg = std::numbers::pi / 180.0;
inline constexpr double rad_s_per_rpm = 2.0 * std::numbers::pi / 60.0;
inline constexpr double nm_per_kgf_cm = 0.0980665; ///< standard gravity 9.80665 m/s² times 0.01 m

constexpr double rad(double deg)
{
    return deg * rad_per_deg;
}
constexpr double deg(double rad)
{
    return rad / rad_per_deg;
}
constexpr double rad_s_from_rpm(double rpm)
{
    return rpm * rad_s_per_rpm;
}
constexpr double rpm(double rad_s)
{
    return rad_s / rad_s_per_rpm;
}
constexpr double nm_from_kgf_cm(double kgf_cm)
{
    return kgf_cm * nm_per_kgf_cm;
}

} // namespace sinew::units
