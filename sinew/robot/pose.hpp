#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/robot/ramp.hpp"

namespace sinew::robot {

/// What moves of a joint keep to: what the robot file says; without it 60 deg/s, so much acceleration that this takes
/// 0.25 s, and so much jerk that that takes 0.1 s.
MotionLimits motion_limits(const config::Joint& joint);

struct PoseOptions {
    std::optional<double> duration_s;
    double speed = 1.0;
};

/// One move into a pose.
config::Sequence sequence_of(const config::Pose& pose, const PoseOptions& options = {});

} // namespace sinew::robot
