#pragma once
#include "sinew/base/time.hpp"
#include "sinew/base/units.hpp"
#include "sinew/wire/profile.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// SAM: the six products, the firmware line and what a device can be told about itself. Line numbers (L…) are those of
/// the SAM series User Manual Ver 1.0; S… are resolutions of README.md.
namespace sinew::sam {

// ---- products ----

/// One of the three coordinate systems of a device. They share their centre: `(raw - centre) * deg_per_unit` is the
/// same shaft angle in each.
struct PositionScale {
    wire::Range control; ///< what may be commanded
    wire::Range sensor;  ///< what may be read
    int centre = 0;      ///< raw value of the shaft's middle position
    double deg_per_unit = 0.0;
    double span_deg = 0.0; ///< printed width of the control range

    constexpr double rad(double raw) const { return units::rad((raw - centre) * deg_per_unit); }
    constexpr double raw(double position_rad) const { return units::deg(position_rad) / deg_per_unit + centre; }
};

/// The specification table, L167-175.
struct Ratings {
    double max_torque_nm = 0.0; ///< at `rated_voltage_v` and `rated_current_a`
    double rated_voltage_v = 0.0;
    double rated_current_a = 0.0;
    double max_speed_rad_s = 0.0;
    double voltage_min_v = 0.0, voltage_max_v = 0.0;
};

struct Model {
    std::string_view name;
    std::uint8_t number = 0; ///< in the firmware reply
    bool encoder = false;    ///< encoder class; has precise positions, the external port and offset control
    PositionScale quick;     ///< one byte, every model
    PositionScale standard;  ///< 12 or 15 bit
    std::optional<PositionScale> precise; ///< 18 or 19 bit, encoder class
    double current_a_per_ad8 = 0.0;       ///< quick load and overload
    double current_a_per_ad12 = 0.0;      ///< standard load and overload
    double voltage_v_per_ad = 0.0;        ///< of the supply; plus `voltage_offset_v`
    double voltage_offset_v = 0.0;
    double speed_deg_s_per_unit = 0.0; ///< of `read-current-speed`
    Duration speed_window{};           ///< the speed is the change of position over this time
    double accel_deg_s2_per_unit = 0.0;
    double boundary_deg_per_unit = 0.0; ///< of the standard boundary commands; the quick ones use the quick scale
    Ratings ratings;
    std::span<const wire::Override> overrides; ///< the same for the codec by name; positions count from the centre
    std::string_view source;
};

/// Boundaries of both kinds are 1 … 254 around this (L462-466, L617-631).
inline constexpr int boundary_centre = 127;
/// Input of the external port, encoder class (L484-486).
inline constexpr double external_v_per_ad = 0.001343;
inline constexpr double external_max_v = 5.5;
/// Every device stops when its inside is this hot (L714).
inline constexpr double overheat_c = 65.0;

std::span<const Model> models();

/// By name or by what people call it: "SAM-160EO200", "SAM-160E0200" (as L167 spells it), "SAM-160", "sam-160".
/// nullptr: none.
const Model* find_model(std::string_view name);
/// By the model number of `read-firmware-version`. nullptr: none with known constants (SAM-140).
const Model* find_model(std::uint8_t number);

/// Whether a product has a message at all: some exist on the encoder class only.
constexpr bool offers(const Model& model, const wire::MessageInfo& message)
{
    return model.encoder || message.info.restriction.empty();
}

// ---- firmware line ----

enum class BoundaryOrder : std::uint8_t { upper_then_lower, lower_then_upper };
enum class PortBits : std::uint8_t { ch_led, do_low };
enum class WheelReply : std::uint8_t { rotation_position, id_id };

/// A firmware line and how its device is set, as a host must know it. Each field but `line` is a key of
/// `[joint.NAME.profile_options]`.
struct Profile {
    wire::Profile line;
    BoundaryOrder quick_boundary_order = BoundaryOrder::upper_then_lower; ///< S32
    PortBits quick_port_bits = PortBits::ch_led;                          ///< S34
    WheelReply wheel_reply = WheelReply::rotation_position;               ///< S27
    bool clockwise_positive = true; ///< GUESS: positions grow clockwise; no document says
    int response_level = 0;         ///< what the device is set to: 0 answers reads, 1 everything, 2 nothing (L655)
    bool ping_is_read = true;       ///< S45: a ping is answered at level 0
    bool quick_id_strict = true;    ///< S30: the quick set-id takes 0 … 30 only
    bool i_gain_strict = false;     ///< S37: the run-time I gain takes 0 … 10 only

    /// Whether the device answers this message (L655, A.2).
    bool answers(const wire::MessageInfo& message) const;
    wire::Options options() const;
};

/// "sam-1.0" only.
std::span<const Profile> profiles();

// ---- what only a device knows ----

enum class BoundaryStorage : std::uint8_t { separate, shared_raw, shared_angle };
enum class OverloadResume : std::uint8_t { automatic, stay_passive };
enum class MotionWrap : std::uint8_t { loop, stop };
enum class MotionRepeat : std::uint8_t { total, additional };
enum class BaudSwitch : std::uint8_t { after_reply, at_power_on };
enum class DriveModeReply : std::uint8_t { new_level, old_level };

/// What the manual leaves open about a device, with the recommended default. Each field is a key of
/// `[joint.NAME.sim]`.
struct DeviceOptions {
    std::uint32_t bit_rate = 1'500'000; ///< not given: that of the bus
    int response_level = 0;             ///< stored at power-on; not given: as the profile says
    bool reverse = false;               ///< stored at power-on
    bool reverse_works = true;          ///< S47: the reverse bit turns the direction round
    bool ping_ignores_id = false;       ///< S51
    bool brake_broadcast_reply = false; ///< S25: answers the brake command of all devices
    bool offset_control_works = true;   ///< S50: 1 makes the present position the centre, 0 takes it back
    BoundaryStorage boundary_storage = BoundaryStorage::separate; ///< S61
    OverloadResume overload_resume = OverloadResume::automatic;   ///< S44; in the file "auto"
    MotionWrap motion_wrap = MotionWrap::loop;                    ///< S65
    MotionRepeat motion_repeat = MotionRepeat::total;             ///< S64: what the count of a repeat counts
    BaudSwitch baud_switch = BaudSwitch::after_reply;             ///< S70
    DriveModeReply drive_mode_reply = DriveModeReply::new_level;  ///< S45
    double fixed_overload_a = 1.8; ///< S69: above it for more than 1 s the device goes passive for 5 s; 0 never
    int flash_writes_max = 10'000; ///< stores nothing after so many writes (L310); 0: never wears out
    bool repeats_checked = true;   ///< S79: ignores a request whose repeated value differs; false: the first one counts
    bool position_ends_modes = true;      ///< S76: false: only special control leaves passive, brake and wheel
    double wheel_middle_duty = 0.325;     ///< S42: of quick speed 8, between 0.15 of 1 and 0.5 of 15: a line
    bool wheel_obeys_boundaries = false;  ///< wheel mode stops at the boundaries of its coordinates
    double overheat_hysteresis_k = 0.0;   ///< S66: how much cooler than 65 degC it must be to go on
    int port_at_power_on = 0;             ///< the four bits of write-external-port
    bool motion_runs_when_written = true; ///< S64: a program starts when it is written; false: at power-on only
    double supply_v = 0.0;                ///< 0: the rated voltage of the model
    double temperature_c = 25.0;          ///< at power-on
    double external_v = 0.0;              ///< at the AD input of the external port, encoder class
    double start_rad = 0.0;               ///< where the shaft stands at power-on
};

// ---- one device ----

/// What a host sets anew after every power-on; not given: as the device has it. Each field is a key of
/// `[joint.NAME.runtime]`. The P and D gains travel together.
struct Runtime {
    std::optional<std::uint8_t> p_gain, d_gain, i_gain;
};

struct Spec {
    const Model* model = nullptr;
    Profile profile;
    int id = 0;
    DeviceOptions device;
    Runtime runtime{};
};

} // namespace sinew::sam
