#pragma once
#include "sinew/actuator/measured.hpp"
#include "sinew/base/time.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

/// An actuator in SI units at its output shaft, whatever the family. Positive is the vendor's own positive sense; a
/// joint adds direction, zero and ratio.
namespace sinew::actuator {

/// What can be wrong with a device, as far as its protocol tells.
enum class Fault : std::uint16_t {
    over_temperature = 1U << 0, ///< of the motor, or of the device where it has one word for both
    low_voltage = 1U << 1,
    high_voltage = 1U << 2,
    driver_over_temperature = 1U << 3,
    over_current = 1U << 4,
    short_circuit = 1U << 5,
    stall = 1U << 6,
    input_lost = 1U << 7,  ///< the device missed commands
    unexplained = 1U << 8, ///< a bit is set that no document explains; `State::raw_faults` has it
};

struct Faults {
    std::uint16_t bits = 0;

    constexpr bool any() const { return bits != 0; }
    constexpr bool has(Fault f) const { return (bits & static_cast<std::uint16_t>(f)) != 0; }
    constexpr void set(Fault f) { bits = static_cast<std::uint16_t>(bits | static_cast<std::uint16_t>(f)); }
    friend constexpr bool operator==(const Faults&, const Faults&) = default;
};

/// What was measured, each value with its time; what was never measured is not there. A plain value without heap.
struct State {
    TimePoint at{}; ///< when the newest value was measured
    Measured<double> position_rad;
    Measured<double> velocity_rad_s;
    Measured<double> current_a; ///< of the motor; without a sign unless `Capabilities::current_has_sign`
    Measured<double> voltage_v; ///< of the supply
    Measured<double> temperature_c;
    Measured<Faults> faults;
    std::uint32_t raw_faults = 0; ///< the bits as the device sent them, as old as `faults`
    Measured<bool> enabled;       ///< whether the device says that it drives its motor

    /// Whether its last word on that is that it does not drive its motor.
    bool says_off() const { return enabled && !*enabled; }

    /// How long ago the newest value was measured.
    Duration age(TimePoint now) const { return now - at; }

    /// Longer than this a velocity says little about where a shaft has gone.
    static constexpr Duration furthest_carry = std::chrono::milliseconds{100};
    /// The position carried on (or back) from when it was measured to `t` by the velocity: latency compensation. An
    /// estimate, not a measurement. Nothing without position and velocity, or where `t` or the velocity lies further
    /// than `furthest` from the position.
    std::optional<double> position_rad_at(TimePoint t, Duration furthest = furthest_carry) const;
};

enum class Mode : std::uint8_t {
    hold,     ///< stay where it is, with torque
    release,  ///< no torque
    brake,    ///< resist without drive: shorted windings, or the brake of the motor
    position, ///< go to `position_rad`
    velocity, ///< turn at `velocity_rad_s` without end
    current,  ///< drive with `current_a`, without end
    torque,   ///< drive with `torque_nm`, without end; where the torque constant is known
    duty,     ///< drive with a share of the supply, without end: open loop
};

/// What is asked of an actuator. What a mode needs and takes:
///
/// | mode     | needs            | takes                                         |
/// |----------|------------------|-----------------------------------------------|
/// | position | `position_rad`   | `velocity_rad_s` or `duration`, `resolution_rad` |
/// | velocity | `velocity_rad_s` | `current_a`, `duration`                       |
/// | current  | `current_a`      |                                               |
/// | torque   | `torque_nm`      |                                               |
/// | duty     | `duty`           |                                               |
///
/// Anything else that is given is refused, so that nothing is left out in silence; hold, release and brake take
/// whatever is there and do not look at it, for a stop must not fail.
struct Command {
    Mode mode = Mode::hold;
    std::optional<double> position_rad;
    std::optional<double> velocity_rad_s; ///< mode position: no faster than this, above 0
    std::optional<double> current_a;      ///< mode velocity: with no more than this, above 0
    std::optional<double> torque_nm;
    std::optional<double> duty;           ///< -1 … 1
    std::optional<Duration> duration;     ///< position: arrive after; velocity: reach it after
    std::optional<double> resolution_rad; ///< as coarse as this will do, for a shorter message; not given: the finest
};

/// Whether an actuator can do something; where it cannot, why.
struct Ability {
    std::string_view why_not = "the actuator cannot do this";

    constexpr operator bool() const { return why_not.empty(); }
};
inline constexpr Ability able{{}};

/// How a move gets its duration.
enum class Timing : std::uint8_t {
    none,
    by_device, ///< the device plans it, ramps included
    by_speed,  ///< the driver asks for the mean speed; ramps make the device later
};

/// What an actuator can do and measure. Asking for more is an error with the reason.
struct Capabilities {
    std::optional<double> position_low_rad, position_high_rad; ///< not given: no end
    double position_step_rad = 0.0;                            ///< what one raw unit means, at the finest
    std::optional<double> velocity_max_rad_s;                  ///< not given: not documented
    Ability velocity;                                          ///< can turn at a velocity
    bool velocity_is_duty = false;                             ///< open loop, in proportion to the rated speed
    Ability velocity_limit;                                    ///< mode position takes a velocity
    Ability timed;                                             ///< mode position takes a duration
    Timing timing = Timing::none;
    Ability timed_velocity; ///< mode velocity takes a duration
    std::optional<Duration> duration_max;
    Ability brake;
    Ability current;
    Ability current_limit;               ///< mode velocity takes a current
    std::optional<double> current_max_a; ///< that a command can carry
    Ability torque;
    std::optional<double> torque_constant_nm_per_a; ///< not given: not known
    Ability duty;
    double duty_max = 1.0;

    bool measures_velocity = false, measures_current = false, measures_voltage = false, measures_temperature = false;
    bool measures_faults = false, measures_enabled = false;
    bool current_has_sign = false;
};

/// What its user allows an actuator, beside what it can do; not given: no such limit. In the units of `Command`.
struct Limits {
    std::optional<double> position_low_rad, position_high_rad;
    std::optional<double> velocity_max_rad_s;
    std::optional<double> current_max_a;
    std::optional<double> torque_max_nm;
    std::optional<double> duty_max;
    std::optional<double> step_max_rad;      ///< between the measured position and a position command
    std::optional<double> temperature_max_c; ///< when it is this hot, nothing but a stop
};

std::string_view to_word(Mode mode);
std::string_view to_word(Fault fault);

} // namespace sinew::actuator
