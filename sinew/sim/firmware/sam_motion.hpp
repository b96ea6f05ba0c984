#pragma once
#include "sinew/family/sam/models.hpp"
#include "sinew/sim/firmware/sam_position_loop.hpp"
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

    /// Once a tick, before the plant runs. Not `may_drive`: the motor is let go, and takes up its mode again after.
    void control(bool may_drive, const SamGains& gains);
    bool is_driving() const { return drive_ == Drive::position || drive_ == Drive::wheel; }
    /// GUESS: without torque until the first command.
    void power_on();

    /// To a raw position of `scale`, limited to what `scale` and `boundary` allow, with a torque of 0 … 2000. GUESS:
    /// leaves any other mode, unless the device is built to stay in it (S76). The registers of S36 limit speed and
    /// acceleration where they are set; without them the shaft is sent there at once.
    void go_to(double raw, const sam::PositionScale& scale, const SamBoundary& boundary, double boundary_deg_per_unit,
               int torque, const SamRegisters& registers);
    void hold();
    void passive();
    void brake();
    /// PWM duty -1 … 1, clockwise positive. GUESS: the boundary does not apply, unless the device is built so.
    void wheel(double duty, const SamBoundary& boundary, double boundary_deg_per_unit);

    void reverse(bool on);
    /// GUESS (S50): the present position becomes the middle one, or that is taken back.
    void offset(bool on);

    sam::Mode mode() const { return mode_; }
    double angle_rad() const; ///< of the sensor, inside ±half a turn
    std::int64_t raw_position(const sam::PositionScale& scale) const;
    std::uint8_t turns() const; ///< GUESS (S27): full turns from the middle position, modulo 255
    std::int16_t raw_speed() const;
    std::int16_t raw_acceleration() const; ///< below 0: it slows down (L1737)
    std::uint16_t raw_load() const;        ///< 12 bit
    std::uint8_t raw_quick_load() const;   ///< 8 bit
    std::uint16_t raw_voltage(double supply_v) const;

private:
    enum class Drive : std::uint8_t { released, braked, position, wheel };

    void to(double target_rad, const SamRegisters& registers);
    bool is_planned() const { return is_planned_ && drive_ == Drive::position; }
    double position_duty(const SamGains& gains);
    double wheel_duty() const;
    double sense() const { return reverse_ ? -1.0 : 1.0; }
    double seen_rad() const { return sense() * plant_.position_rad() - offset_rad_; }

    const sam::Model* model_;
    bool clockwise_positive_;
    bool position_ends_modes_;
    bool wheel_obeys_boundaries_;
    Plant& plant_;
    Rating rating_;
    SamPositionLoop loop_;
    Trajectory trajectory_;
    sam::Mode mode_ = sam::Mode::passive;
    Drive drive_ = Drive::released;
    bool is_planned_ = false; ///< goes along the trajectory, not straight to the target
    bool did_drive_ = false;  ///< in the last tick
    bool reverse_ = false;
    double offset_rad_ = 0.0;
    double target_rad_ = 0.0; ///< of the plant
    double duty_limit_ = 1.0;
    double wheel_duty_ = 0.0;
    double wheel_min_rad_ = 0.0; ///< of the boundary
    double wheel_max_rad_ = 0.0;
    std::array<double, 16> past_{}; ///< positions before the last ticks
    std::size_t now_ = 0;
};

std::string_view to_word(sam::Mode mode);

} // namespace sinew::sim
