#pragma once
#include "sinew/base/time.hpp"

#include <cstdint>

namespace sinew::sim {

/// One step of every plant.
inline constexpr Duration plant_step = std::chrono::milliseconds{1};
inline constexpr double plant_step_s = 0.001;

/// What a plain plant is made of, at its output shaft.
struct Rating {
    double velocity_max_rad_s = 0.0;
    double acceleration_max_rad_s2 = 0.0;
    double current_max_a = 0.0; ///< the current that gives the greatest acceleration
    double supply_v = 0.0;
    double temperature_c = 25.0; ///< it does not heat up
};

/// ASSUMED: no manual gives friction. Share of the greatest torque that is lost as soon as the shaft turns.
inline constexpr double assumed_friction_share = 0.1;

/// A shaft with a limit on speed and on acceleration: it follows a target, turns, is pushed by a current, coasts or is
/// braked. Semi-implicit Euler in steps of one millisecond, the same on every machine; no heap. It has no end stops and
/// knows no protocol; positive is whatever its user calls so.
class Plant
{
public:
    explicit Plant(const Rating& rating, double position_rad = 0.0);

    /// Nothing drives the shaft; friction brings it to rest.
    void release();
    /// Terminals shorted: it comes to rest as fast as it can, without a current from the supply.
    void brake();
    /// To a position at `velocity_rad_s` at most, and stay there. Lands exactly on the target without overshoot when it
    /// can still stop before it. Limits above those of the rating are cut to them; zero acceleration never moves.
    void follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2);
    /// At a speed, until told otherwise.
    void turn(double velocity_rad_s, double acceleration_rad_s2);
    /// With a motor current: the acceleration it gives less friction, up to the greatest speed.
    void push(double current_a);

    void step();

    double position_rad() const { return position_rad_; }
    double velocity_rad_s() const { return velocity_rad_s_; }
    double acceleration_rad_s2() const { return acceleration_rad_s2_; } ///< over the last step
    double current_a() const { return current_a_; }                     ///< of the last step, with its direction
    double voltage_v() const { return rating_.supply_v; }
    double temperature_c() const { return rating_.temperature_c; }
    const Rating& rating() const { return rating_; }

private:
    enum class Drive : std::uint8_t { released, braked, following, turning, pushed };

    double wanted_velocity() const;
    double friction() const;
    void accelerate_towards(double velocity_rad_s, double acceleration_rad_s2);

    Rating rating_;
    Drive drive_ = Drive::released;
    double target_ = 0.0; ///< position, velocity or current, as `drive_` says
    double velocity_limit_ = 0.0;
    double acceleration_limit_ = 0.0;
    double position_rad_ = 0.0;
    double velocity_rad_s_ = 0.0;
    double acceleration_rad_s2_ = 0.0;
    double current_a_ = 0.0;
};

/// The speed between the ramps with which a move from rest to rest over `distance_rad` takes `time_s`; where the
/// acceleration is too small for that, the greatest speed of the fastest move.
double cruise_velocity(double distance_rad, double time_s, double acceleration_rad_s2);

} // namespace sinew::sim
