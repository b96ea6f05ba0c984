#pragma once
#include "apps/cli/moving.hpp"

/// Motion without a target, for a time: `move` with --velocity, --current or --torque.
namespace sinew::cli {

struct Turning {
    actuator::Mode mode = actuator::Mode::velocity;
    double value = 0.0; ///< of the joint: rad/s, A or Nm
    Duration time{};
};

/// What the words ask for; nothing where they ask for none of it. `bad_argument` for two at once or without --for.
std::expected<std::optional<Turning>, Error> turning_from(const Words& words);

/// "elbow will turn at 30 deg/s for 2 s"
std::string describe(const Device& device, const Turning& turning);

/// `out_of_range` where a limit of the robot file is less; nothing has been opened. What else counts is known to
/// `Supervised`.
std::expected<void, Error> check_limits(const Device& device, const Turning& turning);

/// Drives and shows it until the time is over; then it holds, or is released where it was driven by a current or a
/// torque. A joint that comes to its limits, a device that does not answer and Ctrl-C end it early,
/// with torque. `unsupported` where a velocity has moved nothing because it may be too low, `timeout` where something
/// is in the way.
Outcome turn_on(const Words& words, Session& session, Driven& driven, const Turning& turning);

} // namespace sinew::cli
