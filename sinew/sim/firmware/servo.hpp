#pragma once
#include "sinew/sim/plant/plant.hpp"

#include <cstdint>
#include <limits>

namespace sinew::sim {

/// What a plant can do at most, for whoever plans a motion of it.
struct Rating {
    double velocity_max_rad_s = 0.0;
    double acceleration_max_rad_s2 = 0.0;
    double current_max_a = 0.0;
};

/// That of a plant at this voltage, without its load's weight and friction.
Rating rating_of(const PlantParameters& plant, double supply_v);

/// A motion with a limit on speed and on acceleration, from one tick to the next: it follows a target or keeps a speed.
/// Where the shaft should be, whatever it does; the same on every machine; no heap.
class Trajectory
{
public:
    /// At rest in `position_rad`, unless it moves.
    void start(double position_rad, double velocity_rad_s = 0.0);
    /// To a position at `velocity_rad_s` at most, and stay there. Lands exactly on the target without overshoot when it
    /// can still stop before it. Zero acceleration never moves.
    void follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2);
    /// At a speed, until told otherwise; reached by a linear ramp `after_s`, where the acceleration allows that.
    void turn(double velocity_rad_s, double acceleration_rad_s2, double after_s = 0.0);

    void step(); ///< by one tick

    double position_rad() const { return position_rad_; }
    double velocity_rad_s() const { return velocity_rad_s_; }
    double acceleration_rad_s2() const { return acceleration_rad_s2_; } ///< over the last step

private:
    double wanted_velocity() const;
    double most_acceleration() const;

    bool is_following_ = false;
    double target_ = 0.0; ///< position or velocity
    double velocity_limit_ = 0.0;
    double acceleration_limit_ = 0.0;
    double ramp_s_ = 0.0; ///< what is left of it
    double position_rad_ = 0.0;
    double velocity_rad_s_ = 0.0;
    double acceleration_rad_s2_ = 0.0;
};

/// The speed between the ramps with which a move from rest to rest over `distance_rad` takes `time_s`; where the
/// acceleration is too small for that, the greatest speed of the fastest move.
double cruise_velocity(double distance_rad, double time_s, double acceleration_rad_s2);

/// How stiff the loop of a servo is: each gain as a multiple of its usual one.
struct ServoGains {
    double stiffness = 1.0;
    double damping = 1.0;
    double integral = 1.0;
};

/// A motor drive of no particular make: it follows a trajectory with a stiff loop of current, turns, is pushed by a
/// current or a voltage, coasts or is braked. The trajectory waits for a shaft that cannot keep up, so that nothing
/// is made up for when it comes free.
class Servo
{
public:
    /// The loop is critically damped at 25 Hz: slow enough for one of 1 kHz.
    static constexpr double frequency_rad_s = 160.0;

    Servo(Plant& plant, double supply_v) : plant_(&plant), rating_(rating_of(plant.parameters(), supply_v)) {}

    void release();
    void brake();
    /// As `Trajectory` has them, within the rating; a drive that was at rest starts from where the shaft is.
    void follow(double target_rad, double velocity_rad_s, double acceleration_rad_s2);
    void turn(double velocity_rad_s, double acceleration_rad_s2, double after_s = 0.0);
    void push(double current_a);
    void drive(double duty); ///< -1 … 1 of the supply voltage

    /// The loop drives no more than this; without a word the rating. `push` and `drive` know no limit.
    void limit_current(double current_a) { limit_a_ = current_a; }
    void tune(const ServoGains& gains) { gains_ = gains; }

    void control(); ///< once a tick, before the plant runs

    const Rating& rating() const { return rating_; }
    const Trajectory& trajectory() const { return trajectory_; }

private:
    enum class Drive : std::uint8_t { released, braked, following, pushed, driven };

    void begin();
    void hold_to_trajectory();

    Plant* plant_;
    Rating rating_;
    Drive drive_ = Drive::released;
    Trajectory trajectory_;
    ServoGains gains_;
    double limit_a_ = std::numeric_limits<double>::infinity();
    double driven_ = 0.0; ///< current or duty
    double integral_rad_s_ = 0.0;
};

} // namespace sinew::sim
