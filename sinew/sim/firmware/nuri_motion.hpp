#pragma once
#include "sinew/family/nuri/models.hpp"
#include "sinew/sim/firmware/nuri_settings.hpp"
#include "sinew/sim/firmware/servo.hpp"
#include "sinew/sim/plant/plant.hpp"

#include <string_view>

namespace sinew::sim {

/// The part of a Nuri that turns its shaft. Angles and speeds are those behind the external gear, with the sign that
/// counter-clockwise has on this device; the plant is the actuator's own shaft.
class NuriMotion
{
public:
    NuriMotion(const nuri::Spec& spec, Plant& plant);

    void control() { servo_.control(); }
    /// The zero of `reset_position` is lost; the shaft is held if the control is on.
    void power_on(bool on, double gear_ratio, bool inverted);

    // ---- while the control is off these wait for it or are forgotten, as the device is built (N22) ----

    void go_to(double position_rad, double velocity_rad_s);
    /// So that it arrives after `time_s`, as far as the motor can.
    void arrive(double position_rad, double time_s);
    void turn(double velocity_rad_s, double time_s);

    void control(bool on);
    void gear(double ratio) { ratio_ = ratio; }
    void invert(bool on);
    /// The gains and the rated current of whichever controller the next order is for.
    void tune(const NuriController& controller);
    /// GUESS: here is zero, or the shaft goes to the zero there is, as the device is built.
    void reset_position();
    double target_rad() const; ///< of the position order; without one where it is

    double position_rad() const { return to_output(plant_.position_rad() - zero_rad_); }
    double velocity_rad_s() const { return to_output(plant_.velocity_rad_s()); }
    double current_a() const { return plant_.current_a(); }
    std::string_view mode() const;
    const Rating& rating() const { return servo_.rating(); }

private:
    enum class Kind : std::uint8_t { hold, position, speed };

    struct Order {
        Kind kind = Kind::hold;
        double value = 0.0; ///< of the plant
        double velocity_rad_s = 0.0;
        double acceleration_rad_s2 = 0.0;
        double after_s = 0.0; ///< of a speed
    };

    double sign() const { return inverted_ ? -1.0 : 1.0; }
    double to_output(double plant) const { return sign() * plant / ratio_; }
    double to_plant(double output) const { return sign() * output * ratio_; }
    /// What the rated current gives.
    double acceleration() const;
    void accept(const Order& order);
    void act();

    bool off_keeps_target_;
    nuri::PositionReset position_reset_;
    Plant& plant_;
    Servo servo_;
    Order order_;
    bool on_ = true;
    bool inverted_ = false;
    double ratio_ = 1.0;
    double rated_current_a_;
    double zero_rad_ = 0.0;
};

} // namespace sinew::sim
