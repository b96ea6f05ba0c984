#pragma once
#include "sinew/base/time.hpp"
#include "sinew/family/rmd/identifiers.hpp"
#include "sinew/wire/profile.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// RMD: motor classes, the five firmware lines and what a device can be told about itself. R… are resolutions of
/// README.md; "field notes" are the vendor documents and drivers named there.
namespace sinew::rmd {

/// What the reply field `iq` of a class means.
enum class Iq : std::uint8_t {
    unknown, ///< no class given: raw units only
    current, ///< torque current
    power,   ///< power, -1000 … 1000 (MS)
};

struct Model {
    std::string_view name;
    Iq iq = Iq::unknown;
    double torque_current_full_scale_a = 0.0; ///< at raw 2048, class `Iq::current` only
    std::string_view says;
    std::string_view source;
};

/// "RMD" (any motor, current unscaled), "MF", "MG", "MS", "RMD-L".
std::span<const Model> models();
/// In any case. nullptr: none.
const Model* find_model(std::string_view name);

/// Until a motor starts to answer (LK V2.35 and V2.36; the manual is silent).
inline constexpr Duration response_time = std::chrono::microseconds{250};

/// The first byte of the answer to clear-error (R04). Hosts take both; a device sends this one.
enum class ClearErrorReply : std::uint8_t { as_printed_9a, own_9b };

/// What a line sends as error state.
enum class ErrorBits : std::uint8_t {
    two,     ///< bit 0 low voltage, bit 3 over temperature; others are not explained (R31)
    eight,   ///< lk-2.36
    sixteen, ///< myactuator-3; kept raw
};

/// Whose rows a line has; a host picks the row types of `messages.hpp` or `lines.hpp` by it.
enum class Dialect : std::uint8_t { manual, lk, lk_2_36, gyems, myactuator };

/// A firmware line and how its device is set, as a host must know it. The fields of the second group are keys of
/// `[joint.NAME.profile_options]`; those of the first belong to the line.
struct Profile {
    wire::Profile line;
    Dialect dialect = Dialect::manual;
    std::uint32_t reply_identifier_base = identifier_base; ///< replies come on this + id
    double voltage_lsb_v = 0.1;                            ///< of read-status1
    double phase_current_lsb_a = 1.0 / 64.0;               ///< of read-status3; 0: as torque current
    ErrorBits error_bits = ErrorBits::two;
    bool iq_in_centiamperes = false; ///< torque currents are 0.01 A on every model

    double max_speed_lsb_dps = 0.01;  ///< R01: of A4, A6 and A8; 0.01 or 1
    bool max_speed_confirmed = false; ///< somebody named the profile or the scale; else a host must not trust it
    ClearErrorReply clear_error_reply = ClearErrorReply::as_printed_9a; ///< R04
    std::optional<double> torque_current_full_scale_a{}; ///< R11: instead of that of the model, such as 32 for MG
    int encoder_bits = 14;                               ///< 12 … 18; no more than 16 of them are sent
    bool off_requires_run = false;                       ///< R30: after motor-off nothing moves until motor-running
    double gear_ratio = 1.0; ///< turns of the shaft that angles and speeds count, for one of the output (field notes 2)
    std::optional<double> torque_constant_nm_per_a{}; ///< at the output, of the torque current; no document has one

    /// The scale that a host sends max_speed with. Unless confirmed it is the one that can only be too slow: a motor
    /// that reads 0.01 turns at a hundredth, and none turns faster than asked.
    constexpr double sent_max_speed_lsb_dps() const
    {
        return max_speed_confirmed || max_speed_lsb_dps > 1.0 ? max_speed_lsb_dps : 1.0;
    }
    constexpr int sent_encoder_bits() const { return encoder_bits < 16 ? encoder_bits : 16; }
    wire::Options options() const;
};

/// "rmd-2.35" (the manual, default), "lk-2.35", "lk-2.36", "gyems-1.62", "myactuator-3".
std::span<const Profile> profiles();

enum class IncrementBase : std::uint8_t { target, position };
enum class OffsetEffect : std::uint8_t { at_once, at_power_on };

/// What the manual leaves open about a device, with the recommended default. Each field is a key of
/// `[joint.NAME.sim]`.
struct DeviceOptions {
    std::uint32_t bit_rate = 1'000'000;                         ///< not given: that of the bus
    IncrementBase increment_base = IncrementBase::target;       ///< R29: what A7 and A8 add to while positioning
    OffsetEffect encoder_offset_effect = OffsetEffect::at_once; ///< R07: of 0x91
    bool multi_motor = true;                                    ///< R25: listens to 0x280
    bool stops_on_fault = true;               ///< R26: switches itself off until a fault is over and cleared
    bool reply_lag = false;                   ///< field notes 2: control replies tell the state at the frame before
    bool turns_kept = false;                  ///< R38: the multi-turn angle outlives a power cut
    bool echoes_unknown = false;              ///< R43: an unknown command byte comes back; false: silence
    double supply_v = 24.0;                   ///< ASSUMED: inside the limits of R26
    double low_voltage_v = 7.0;               ///< R26
    double over_voltage_v = 26.0;             ///< R26
    double temperature_c = 25.0;              ///< at power-on
    double temperature_limit_c = 100.0;       ///< R26
    double max_speed_dps = 0.0;               ///< MaxSpeed of the setting tool; 0: the assumed no-load speed
    double max_acceleration_dps_s = 10'000.0; ///< ASSUMED: MaxAcceleration of the setting tool
    double max_angle_deg = 0.0;               ///< MaxAngle of the setting tool; 0: no limit
    double start_rad = 0.0;                   ///< where the shaft stands at power-on
};

/// The gains of one loop as the motor has them; their unit is in no document (R17).
struct LoopGains {
    std::optional<std::uint16_t> kp, ki, kd;

    bool given() const { return kp || ki || kd; }
};

/// What a host sets anew after every power-on; not given: as the motor has it. Each field is a key of
/// `[joint.NAME.runtime]`. The gains of a loop travel together.
struct Runtime {
    std::optional<double> acceleration_rad_s2; ///< at the output
    LoopGains angle, speed, current;
};

struct Spec {
    const Model* model = nullptr;
    Profile profile;
    int id = 1;
    DeviceOptions device;
    Runtime runtime{};
    /// What model and options change in the reading of rows, for the codec by name. `make_spec` fills it.
    std::array<wire::Override, 20> overrides{};
    std::size_t override_count = 0;

    /// Of the frames with which it answers.
    std::uint32_t reply_identifier() const { return profile.reply_identifier_base + static_cast<std::uint32_t>(id); }
    /// Amperes per raw unit of `iq` in replies; not given: not known.
    std::optional<double> iq_a() const;
    /// Amperes per raw unit of the phase currents; 0: not known.
    double phase_current_a() const;
};

/// A device with everything worked out.
Spec make_spec(const Model& model, const Profile& profile, int id, const DeviceOptions& device = {});

} // namespace sinew::rmd
