#pragma once
#include "sinew/base/time.hpp"
#include "sinew/base/units.hpp"

#include <string_view>

/// The one table of what no document gives: ASSUMED, every number of it. The simulator works with these values; no host
/// code may rely on them. 0: the document has it.
namespace sinew {

struct Assumption {
    std::string_view family, model;
    double inertia_kg_m2 = 0.0;       ///< of rotor and gear, at the output
    double no_load_speed_rad_s = 0.0; ///< at the rated voltage
    double stall_torque_nm = 0.0;
    double stall_current_a = 0.0; ///< also the default and the upper limit of Nuri's rated current
    double rated_voltage_v = 0.0;
    std::string_view reason;
};

namespace assumed_because {
inline constexpr std::string_view sam = "full speed in about 0.1 s with the printed torque: J = T * 0.1 s / w";
inline constexpr std::string_view nuri = "the document names no product (N28, N30); a 24 V gear motor of about 30 W";
inline constexpr std::string_view rmd = "no table of models (R13); a 24 V gimbal motor of this current class";
} // namespace assumed_because

inline constexpr Assumption assumptions[] = {
    {.family = "sam", .model = "SAM-5", .inertia_kg_m2 = 0.0036, .reason = assumed_because::sam},
    {.family = "sam", .model = "SAM-20", .inertia_kg_m2 = 0.013, .reason = assumed_because::sam},
    {.family = "sam", .model = "SAM-28", .inertia_kg_m2 = 0.029, .reason = assumed_because::sam},
    {.family = "sam", .model = "SAM-160EO200", .inertia_kg_m2 = 0.24, .reason = assumed_because::sam},
    {.family = "sam", .model = "SAM-180EO200", .inertia_kg_m2 = 0.34, .reason = assumed_because::sam},
    {.family = "sam", .model = "SAM-210EO200", .inertia_kg_m2 = 0.47, .reason = assumed_because::sam},
    {"nuri", "RSA", 0.05, units::rad_s_from_rpm(60.0), 3.0, 1.0, 24.0, assumed_because::nuri},
    {"nuri", "MC", 0.05, units::rad_s_from_rpm(60.0), 3.0, 1.0, 24.0, assumed_because::nuri},
    {"rmd", "RMD", 0.002, units::rad(1800.0), 2.0, 3.0, 24.0, assumed_because::rmd},
    {"rmd", "MF", 0.002, units::rad(1800.0), 2.0, 3.0, 24.0, assumed_because::rmd},
    {"rmd", "MG", 0.02, units::rad(720.0), 12.0, 8.0, 24.0, assumed_because::rmd},
    {"rmd", "MS", 0.001, units::rad(2400.0), 0.5, 1.0, 24.0, assumed_because::rmd},
    {"rmd", "RMD-L", 0.002, units::rad(1800.0), 2.0, 3.0, 24.0, assumed_because::rmd},
};

/// How long a SAM may take to answer; the manual is silent (S82). Its loops run every millisecond.
inline constexpr Duration assumed_sam_response_typical = std::chrono::microseconds{200};
inline constexpr Duration assumed_sam_response_most = std::chrono::milliseconds{2};

/// The row of a model, by the name that `models.hpp` gives it; nullptr: none.
constexpr const Assumption* assumption(std::string_view family, std::string_view model)
{
    for (const Assumption& one : assumptions)
        if (one.family == family && one.model == model)
            return &one;
    return nullptr;
}

} // namespace sinew
