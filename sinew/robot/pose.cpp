#include "sinew/robot/pose.hpp"

#include "sinew/base/units.hpp"

namespace sinew::robot {

MotionLimits motion_limits(const config::Joint& joint)
{
    constexpr double gentle_rad_s = units::rad(60.0);
    constexpr double speeding_up_s = 0.25, pushing_s = 0.1;
    const double velocity = joint.velocity_max_rad_s.value_or(gentle_rad_s);
    const double acceleration = joint.acceleration_max_rad_s2.value_or(velocity / speeding_up_s);
    return {.velocity_rad_s = velocity,
            .acceleration_rad_s2 = acceleration,
            .jerk_rad_s3 = joint.jerk_max_rad_s3.value_or(acceleration / pushing_s)};
}

config::Sequence sequence_of(const config::Pose& pose, const PoseOptions& options)
{
    config::Step step{.kind = config::Step::Kind::move, .at = pose.at, .name = {pose.name, pose.at}};
    step.targets = pose.targets;
    step.duration_s = options.duration_s;
    step.speed = options.speed;
    config::Sequence out{.name = pose.name, .at = pose.at};
    out.steps.push_back(std::move(step));
    return out;
}

} // namespace sinew::robot
