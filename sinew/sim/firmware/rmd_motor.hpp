#pragma once
#include "sinew/family/rmd/models.hpp"
#include "sinew/sim/firmware/servo.hpp"
#include "sinew/sim/plant/plant.hpp"

#include <cstdint>
#include <limits>
#include <string_view>

namespace sinew::sim {

/// What an order may use of the motor. With a limit of 0 it does not move.
struct RmdLimits {
    double velocity_rad_s = std::numeric_limits<double>::infinity();
    double acceleration_rad_s2 = std::numeric_limits<double>::infinity();
    double current_a = std::numeric_limits<double>::infinity();
};

/// The part of an RMD that turns its shaft: orders, the off and stopped states, the encoder and the two angles.
/// Positive is clockwise, as the protocol has it; all angles are those of the shaft that the protocol speaks of.
class RmdMotor
{
public:
    RmdMotor(const rmd::Spec& spec, Plant& plant);

    void control() { servo_.control(); }
    /// On, without an order (LK V2.35). The turn counter is lost: both angles start inside one turn from the offset
    /// (R38).
    /// `turns_kept`: the multi-turn angle goes on as it was.
    void power_on(std::uint16_t encoder_offset, bool turns_kept);

    // ---- orders; in the off state they wait for `run`, or switch the motor on, as the profile says (R30) ----

    void push(double current_a);
    void drive(double share); ///< of the supply voltage, -1 … 1
    void turn(double velocity_rad_s, const RmdLimits& limits);
    void go_to(double multi_turn_rad, const RmdLimits& limits);
    /// Inside one turn, in the given direction until the angle fits (R28).
    void go_to_single(double single_turn_rad, bool clockwise, const RmdLimits& limits);
    /// Relative to the target of a position order, or to where it is (R29).
    void go_on(double angle_rad, const RmdLimits& limits);

    void off();  ///< forgets the order, and by LK-Tech's manuals the turns (field notes 1)
    void stop(); ///< keeps it
    void run();
    void engage_brake(bool engaged);

    // ---- the zero of the angles ----

    void set_encoder_offset(std::uint16_t offset);
    void set_zero(); ///< of both angles
    void set_multi_turn(double multi_turn_rad);

    double multi_turn_rad() const { return plant_.position_rad() - multi_turn_zero_rad_; }
    double single_turn_rad() const; ///< 0 … one turn
    std::uint16_t encoder_raw() const;
    std::uint16_t encoder() const;
    std::uint16_t encoder_offset() const { return encoder_offset_; }
    bool is_off() const { return state_ == State::off; }
    bool brake_engaged() const { return brake_engaged_; }
    std::string_view mode() const;
    const Rating& rating() const { return servo_.rating(); }

private:
    void lose_turns();
    enum class State : std::uint8_t { on, stopped, off };
    enum class Kind : std::uint8_t { nothing, torque, power, speed, position };

    struct Order {
        Kind kind = Kind::nothing;
        double value = 0.0; ///< A, share, rad/s, or the plant's own position
        double velocity_rad_s = 0.0;
        double acceleration_rad_s2 = 0.0;
        double current_a = std::numeric_limits<double>::infinity();
    };

    void accept(const Order& order);
    void act();
    double acceleration(const RmdLimits& limits) const;
    double offset_rad() const;

    bool off_requires_run_;
    rmd::IncrementBase increment_base_;
    std::uint32_t encoder_steps_;
    Plant& plant_;
    Servo servo_;
    State state_ = State::on;
    Order order_;
    bool brake_engaged_ = false;
    std::uint16_t encoder_offset_ = 0;
    double single_turn_zero_rad_ = 0.0;
    double multi_turn_zero_rad_ = 0.0;
};

} // namespace sinew::sim
