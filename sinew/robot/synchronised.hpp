#pragma once
#include "sinew/robot/trajectory.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace sinew::robot {

/// What one joint does in a synchronised motion.
struct JointMotion {
    double from_rad = 0.0;
    double from_velocity_rad_s = 0.0;
    double target_rad = 0.0;
    MotionLimits limits;
};

/// Several joints that begin together and arrive together: the slowest sets the time, the others take as long. Each
/// joint keeps its own limits. The heap is asked by `reserve` and by a plan for more joints than were reserved, never
/// by sampling. One thread plans; any may sample a plan that nobody changes.
class Synchronised
{
public:
    void reserve(std::size_t joints);

    /// The soonest common arrival, or exactly `duration`. The motion before is forgotten, and is kept when this fails:
    /// `out_of_range` with the index of the joint as `Error::value` and the duration that can be had; what
    /// `Trajectory::plan` refuses likewise. No joints: a motion without duration.
    std::expected<void, Error> plan(std::span<const JointMotion> joints, std::optional<Duration> duration = {});

    Duration duration() const { return duration_; }
    std::size_t size() const { return all_.size(); }
    const Trajectory& joint(std::size_t index) const { return all_[index]; }
    /// Of joint `index` in the order of the plan.
    Setpoint at(std::size_t index, Duration since_start) const { return all_[index].at(since_start); }

private:
    std::vector<Trajectory> all_, next_;
    Duration duration_{};
};

} // namespace sinew::robot
