#pragma once
#include "sinew/family/setting.hpp"

/// Nuri: what a device keeps. Everything goes to flash at once (N14). The control switch comes last: it takes the
/// torque off.
namespace sinew::nuri {

inline constexpr SettingInfo settings[] = {
    {.name = "position-controller", .read = "request-position-controller-feedback", .write = "set-position-controller"},
    {.name = "speed-controller", .read = "request-speed-controller-feedback", .write = "set-speed-controller"},
    {.name = "response-time", .read = "request-response-time-feedback", .write = "set-response-time"},
    {.name = "rated-speed", .read = "request-rated-speed-feedback", .write = "set-rated-speed"},
    {.name = "resolution", .read = "request-resolution-feedback", .write = "set-resolution"},
    {.name = "external-gear-ratio", .read = "request-gear-ratio-feedback", .write = "set-external-gear-ratio"},
    {.name = "position-control-mode", .read = "request-position-mode-feedback", .write = "set-position-control-mode"},
    {.name = "control-direction", .read = "request-control-direction-feedback", .write = "set-control-direction"},
    {.name = "control-on-off", .read = "request-control-on-off-feedback", .write = "set-control-on-off"},
};

/// N25.
inline constexpr ZeroInfo zeroes[] = {
    {.message = "reset-position", .says = "no document says whether it holds after a power-off"}};

inline constexpr GainInfo gains[] = {{"p", "position-controller", "position_kp"},
                                     {"i", "position-controller", "position_ki"},
                                     {"d", "position-controller", "position_kd"}};

} // namespace sinew::nuri
