#pragma once
#include "sinew/family/sam/models.hpp"
#include "sinew/sim/firmware/sam_settings.hpp"
#include "sinew/sim/firmware/servo.hpp"
#include "sinew/sim/plant/plant.hpp"

#include <array>
#include <cstdint>
#include <string_view>

namespace sinew::sim {

/// The part of a SAM that turns its shaft: modes, coordinates and read-outs. Angles are radians from the middle
/// position that all coordinate systems share, growing with them; in reverse mode, and after an offset, they are those
/// that the device sees.
class SamMotion
{
public:
    SamMotion(const sam::Spec& spec, Plant& plant);

    void control(); ///< once a tick, before the plant runs
    /// GUESS: without torque until the first command.
    void power_on();

    /// To a raw position of `scale`, limited to what `scale` and `boundary` allow, with a torque of 0 … 2000. GUESS:
    /// leaves any other mode (S76). The registers of S36 limit speed and acceleration.
    void go_to(double raw, const sam::PositionScale& scale, const SamBoundary& boundary, double boundary_deg_per_unit,
               int torque, const SamRegisters& registers);
    void hold();
    void passive();
    void brake();
    /// PWM duty -1 … 1, clockwise positive. GUESS: angle limits do not apply.
    void wheel(double duty);

    void reverse(bool on);
    /// GUESS (S50): the present position becomes the middle one, or that is taken back.
    void offset(bool on);

    sam::Mode mode() const { return mode_; }
    double angle_rad() const; ///< of the sensor, inside ±half a turn
    std::int64_t raw_position(const sam::PositionScale& scale) const;
    std::uint8_t turns() const; ///< GUESS (S27): full turns from the middle position, modulo 255
    std::int16_t raw_speed() const;
    std::int16_t raw_acceleration() const;
    std::uint16_t raw_load() const;      ///< 12 bit
    std::uint8_t raw_quick_load() const; ///< 8 bit
    std::uint16_t raw_voltage(double supply_v) const;
    bool too_hot() const;
    const Rating& rating() const { return servo_.rating(); }

private:
    double sense() const { return reverse_ ? -1.0 : 1.0; }
    double seen_rad() const { return sense() * plant_.position_rad() - offset_rad_; }

    const sam::Model* model_;
    bool clockwise_positive_;
    Plant& plant_;
    Servo servo_;
    sam::Mode mode_ = sam::Mode::passive;
    bool reverse_ = false;
    double offset_rad_ = 0.0;
    std::array<double, 16> past_{}; ///< positions after the last steps
    std::size_t now_ = 0;
};

std::string_view to_word(sam::Mode mode);

} // namespace sinew::sim
