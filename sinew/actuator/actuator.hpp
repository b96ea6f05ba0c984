#pragma once
#include "sinew/base/time.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

/// An actuator in SI units at its output shaft, whatever the family. Positive is the vendor's own positive sense; a
/// joint adds direction, zero and ratio.
namespace sinew::actuator {

/// What can be wrong with a device, as far as its protocol tells.
enum class Fault : std::uint8_t {
    over_temperature = 1U << 0,
    low_voltage = 1U << 1,
    unexplained = 1U << 7, ///< a bit is set that no document explains; `State::raw_faults` has it
};

struct Faults {
    std::uint8_t bits = 0;

    constexpr bool any() const { return bits != 0; }
    constexpr bool has(Fault f) const { return (bits & static_cast<std::uint8_t>(f)) != 0; }
    constexpr void set(Fault f) { bits = static_cast<std::uint8_t>(bits | static_cast<std::uint8_t>(f)); }
};

/// What was measured; what was not measured is not there.
struct State {
    TimePoint at{}; ///< when the newest value arrived
    std::optional<double> position_rad;
    std::optional<double> velocity_rad_s;
    std::optional<double> current_a;
    std::optional<double> voltage_v;
    std::optional<double> temperature_c;
    std::optional<Faults> faults;
    std::uint32_t raw_faults = 0; ///< the bits as the device sent them
};

enum class Mode : std::uint8_t {
    hold,     ///< stay where it is, with torque
    release,  ///< no torque
    position, ///< go to `position_rad`
    velocity, ///< turn at `velocity_rad_s` without end
};

/// What is asked of an actuator. `velocity_rad_s` is the target of mode velocity and a limit in mode position, where it
/// must be positive if given.
struct Command {
    Mode mode = Mode::hold;
    std::optional<double> position_rad;
    std::optional<double> velocity_rad_s;
};

/// What an actuator can do and measure. Asking for more is an error with the reason.
struct Capabilities {
    std::optional<double> position_low_rad, position_high_rad; ///< not given: no end
    double position_step_rad = 0.0;                            ///< what one raw unit means
    std::optional<double> velocity_max_rad_s;                  ///< not given: not documented
    bool velocity = false;                                     ///< can turn at a velocity
    bool velocity_limit = false;                               ///< mode position takes a velocity
    bool measures_velocity = false, measures_current = false, measures_voltage = false, measures_temperature = false;
};

std::string_view to_word(Mode mode);

} // namespace sinew::actuator
