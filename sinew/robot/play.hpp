#pragma once
#include "sinew/robot/robot.hpp"
#include "sinew/robot/sequence.hpp"

#include <functional>
#include <span>
#include <string>

/// Synchronised motions of a whole robot: poses, sequences, joints by name.
namespace sinew::robot {

struct PlayOptions {
    Duration period = std::chrono::milliseconds{10}; ///< between two targets
    double speed = 1.0;                              ///< share of the fastest motions, above 0 up to 1
    std::function<void(const SequencePlayer&)> each; ///< once a period
    std::function<bool()> stop_asked;                ///< asked once a period: what moves slows down, and it ends
};

/// Motions keep so far below the greatest velocity of a joint, so that a loop that is a little late stays within it.
inline constexpr double speed_kept = 0.95;

/// Plays a sequence of the robot's file on an enabled robot, until its end. Targets are streamed at the rate of each
/// bus, in steps that its joint may take; a motion waits for a joint that has fallen behind. A device that plans timed
/// moves itself, ramps included, gets each motion as one. Afterwards the joints hold
/// where they are; it returns when they are within half a degree of that, or after half a second. `done` or `stopped`;
/// an error when the sequence fails (see `SequencePlayer::error`; what moved has slowed down), when a command is
/// refused (likewise), or when something stops the robot.
std::expected<SequencePlayer::Status, Error> play(Robot& robot, const config::Sequence& sequence,
                                                  const PlayOptions& options = {});

struct NamedTarget {
    std::string joint;
    double position_rad = 0.0;
};

/// Moves some joints so that they begin and arrive together, the soonest or after `duration`. `unknown_name` or
/// `out_of_range` before anything moves; else as `play`.
std::expected<SequencePlayer::Status, Error> move(Robot& robot, std::span<const NamedTarget> targets,
                                                  std::optional<Duration> duration = {},
                                                  const PlayOptions& options = {});

} // namespace sinew::robot
