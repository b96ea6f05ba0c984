#pragma once
#include "sinew/family/setting.hpp"

/// SAM: what a device keeps. The order is that in which it is written: the drive mode, which decides whether commands
/// are answered, comes last. The quick overload is the standard one in other units (S60) and not listed; the quick
/// boundaries are registers of their own (S61). The motion program cannot be read.
namespace sinew::sam {

inline constexpr SettingInfo settings[] = {
    {.name = "pd-gain", .read = "read-pd-gain", .write = "set-pd-gain", .trial = "set-runtime-pd-gain"},
    {.name = "i-gain", .read = "read-i-gain", .write = "set-i-gain", .trial = "set-runtime-i-gain"},
    {.name = "overload", .read = "read-overload", .write = "set-overload"},
    {.name = "boundary", .read = "read-boundary", .write = "set-boundary"},
    {.name = "quick-boundary", .read = "quick-read-boundary", .write = "quick-set-boundary"},
    {.name = "avg-torque", .read = "read-avg-torque", .write = "set-avg-torque"},
    {.name = "ctrl-speed", .read = "read-ctrl-speed", .write = "set-ctrl-speed"},
    {.name = "ctrl-torque", .read = "read-ctrl-torque", .write = "set-ctrl-torque"},
    {.name = "ctrl-accel", .read = "read-ctrl-accel", .write = "set-ctrl-accel"},
    {.name = "ctrl-decel", .read = "read-ctrl-decel", .write = "set-ctrl-decel"},
    {.name = "drive-mode", .read = "read-drive-mode", .write = "set-drive-mode", .decides_answers = true},
};

/// S50: named only by the code listing.
inline constexpr ZeroInfo zeroes[] = {{.message = "offset-control",
                                       .field = "offset_control",
                                       .raw = 1,
                                       .undo = 0,
                                       .says = "no document says whether it holds after a power-off"}};

inline constexpr GainInfo gains[] = {{"p", "pd-gain", "p_gain"}, {"i", "i-gain", "i_gain"}, {"d", "pd-gain", "d_gain"}};

} // namespace sinew::sam
