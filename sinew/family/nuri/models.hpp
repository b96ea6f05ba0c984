#pragma once
#include "sinew/base/time.hpp"
#include "sinew/wire/profile.hpp"

#include <cstdint>
#include <span>
#include <string_view>

/// Nuri: firmware lines and what a device can be told about itself. The document names no product and prints no rating;
/// what a simulator needs of them stands in `family/assumed.hpp`. N… are resolutions of README.md.
namespace sinew::nuri {

struct Model {
    std::string_view name;
    std::string_view line; ///< profile of its firmware, unless another one is asked for
    std::string_view says;
    std::string_view source;
};

/// "RSA" (the document) and "MC".
std::span<const Model> models();
/// Also by the names of series with the same messages, in any case. nullptr: none.
const Model* find_model(std::string_view name);

enum class PositionFeedbackLimit : std::uint8_t { clamp, wrap };

/// A firmware line and how its device is set, as a host must know it. Each field but `line` is a key of
/// `[joint.NAME.profile_options]`.
struct Profile {
    wire::Profile line;
    bool ccw_positive = true; ///< N16: counter-clockwise is the positive sense
    PositionFeedbackLimit position_feedback_limit = PositionFeedbackLimit::clamp; ///< N17: beyond 655.33 deg
    bool control_direction = true;    ///< N08: mode 0x0F of the appendix may be sent; false: it is refused
    double external_gear_ratio = 1.0; ///< N33: set by mode 9; positions and speeds are those behind it
    double response_time_us = 100.0;  ///< what the device is set to, 0 … 25 400 (L56)

    wire::Options options() const { return line.options; }
    Duration response_time() const
    {
        return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(response_time_us));
    }
};

/// "rsa" (the document, default) and "mc".
std::span<const Profile> profiles();

enum class RelativeBase : std::uint8_t { position, target };
enum class PositionReset : std::uint8_t { here_is_zero, go_to_zero };
enum class BusSwitch : std::uint8_t { at_once, at_power_on };

/// What the document leaves open about a device, with the recommended default. Each field is a key of
/// `[joint.NAME.sim]`.
struct DeviceOptions {
    std::uint32_t bit_rate = 9600;       ///< not given: that of the bus
    bool settings_persist = true;        ///< N14: settings survive a power cut
    bool control_direction_works = true; ///< N08: mode 0x0F turns the direction of control round
    bool off_keeps_target = false;       ///< N22: a motion command that came while off is carried out at on
    RelativeBase relative_base = RelativeBase::position;        ///< what relative positions add to while positioning
    PositionReset position_reset = PositionReset::here_is_zero; ///< what mode 0x0C initialises
    BusSwitch bus_switch = BusSwitch::at_once;                  ///< N15: when another id or bit rate counts
    bool reset_keeps_bus = false;                               ///< N24: id and bit rate outlive a factory reset
    double rated_current_a = 0.0; ///< N19: default and upper limit of the rated current; 0: the assumed one
    double supply_v = 0.0;        ///< 0: the assumed rated voltage
    double start_rad = 0.0;       ///< where the shaft stands at power-on
};

struct Spec {
    const Model* model = nullptr;
    Profile profile;
    int id = 0;
    DeviceOptions device;
};

} // namespace sinew::nuri
