#pragma once
#include "sinew/family/rmd/messages.hpp"
#include "sinew/family/setting.hpp"

/// RMD: what a device keeps. The acceleration is forgotten at power-off: no message stores it (R06). The encoder offset
/// belongs to the magnet of this one motor.
namespace sinew::rmd {

consteval SettingInfo stored_parameter(std::string_view name, ParameterId id)
{
    return {.name = name,
            .read = "read-parameter",
            .write = "write-parameter-rom",
            .trial = "write-parameter-ram",
            .selected = static_cast<std::int64_t>(id)};
}

inline constexpr SettingInfo settings[] = {
    stored_parameter("angle-pid", ParameterId::angle_pid),
    stored_parameter("speed-pid", ParameterId::speed_pid),
    stored_parameter("current-pid", ParameterId::current_pid),
    stored_parameter("max-torque-current", ParameterId::max_torque_current),
    stored_parameter("max-speed", ParameterId::max_speed),
    stored_parameter("max-angle-low", ParameterId::max_angle_low),
    stored_parameter("max-angle-high", ParameterId::max_angle_high),
    stored_parameter("current-ramp", ParameterId::current_ramp),
    stored_parameter("speed-ramp", ParameterId::speed_ramp),
    {.name = "pid", .read = "read-pid", .write = "write-pid-rom", .trial = "write-pid-ram"},
    {.name = "acceleration", .read = "read-acceleration", .write = "write-acceleration-ram"},
    {.name = "encoder-offset", .read = "read-encoder", .write = "write-encoder-offset", .calibration = true},
};

inline constexpr ZeroInfo zeroes[] = {
    {.message = "set-current-position-zero", .says = "it holds until power-off"},
    {.message = "set-current-angle", .field = "angle", .says = "it holds until power-off"},
    {.message = "write-current-position-zero-rom", .says = "it is stored, and counts after the next power-on"},
};

/// One line has parameters, another the gains of its loops in one message.
inline constexpr GainInfo gains[] = {{"p", "angle-pid", "kp"},
                                     {"i", "angle-pid", "ki"},
                                     {"d", "angle-pid", "kd"},
                                     {"p", "pid", "angle_kp"},
                                     {"i", "pid", "angle_ki"}};

} // namespace sinew::rmd
