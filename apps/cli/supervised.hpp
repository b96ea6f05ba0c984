#pragma once
#include "apps/cli/rest.hpp"
#include "sinew/robot/supervisor.hpp"

/// What the supervisor of a robot's joints does, for one device that a verb drives: `move`, `home` and `tune`.
namespace sinew::cli {

/// How a position may be reached at once.
enum class Reached {
    in_steps,  ///< no step is longer than `velocity_max_deg_s` allows
    by_a_leap, ///< only `step_max_deg` counts: whoever measures a step wants to see it
};

/// Holds one device to the limits of the robot file: what is sent, and what is measured. The device must have been read
/// wholly; nothing is sent before `send`. In joint units.
class Supervised
{
public:
    Supervised(Session& session, Driven& driven, Reached reached = Reached::in_steps);

    /// Carries it out if it is within the limits and nothing is wrong with the device; then that is what runs.
    std::expected<void, Error> send(const actuator::Command& command);
    /// Whether anything has been, acknowledged or not: else an error has moved nothing.
    bool has_sent() const { return has_sent_; }
    /// Reads it, now and then wholly. An error where that failed, or where what was measured may not go on; of a limit
    /// of the robot file it is `out_of_range`.
    std::expected<void, Error> look();
    /// The position that moves begin at: the last that was sent, else the last that was measured.
    std::optional<double> reference_rad() const { return guard_.reference_rad(); }

private:
    actuator::State state() const;
    std::expected<void, Error> judge(Duration interval);

    Session& session_;
    Driven& driven_;
    robot::Supervisor guard_;
    Duration between_full_;
    actuator::Command running_{.mode = actuator::Mode::hold};
    bool has_sent_ = false;
    TimePoint placed_at_; ///< its position was measured last
    TimePoint looked_at_;
    TimePoint full_at_; ///< the next full reading is due
};

/// The end of a motion for an error: it comes to rest. That it came to a limit is said here, and has an exit code of
/// its own.
Outcome stopped_for(Session& session, Driven& driven, const Error& why, Otherwise otherwise = Otherwise::nothing);

} // namespace sinew::cli
