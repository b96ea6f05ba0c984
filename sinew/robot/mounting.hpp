#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/config/robot_file.hpp"

namespace sinew::robot {

/// How an actuator is built in: between the units of the device and those of its joint. Positions have a zero, and with
/// velocities and steps they share direction and ratio; a torque is multiplied by the ratio, a current keeps its size.
/// Without heap.
struct Mounting {
    double direction = 1.0; ///< +1 or -1
    double ratio = 1.0;     ///< turns of the actuator for one of the joint
    double zero_rad = 0.0;  ///< of the actuator where the joint is at 0

    static Mounting of(const config::Joint& joint);

    double to_joint(double actuator_rad) const { return (actuator_rad - zero_rad) / (direction * ratio); }
    double to_joint_velocity(double actuator_rad_s) const { return actuator_rad_s / (direction * ratio); }
    /// The zero by which the actuator is here where the joint is there.
    double zero_rad_at(double actuator_rad, double joint_rad) const
    {
        return actuator_rad - joint_rad * direction * ratio;
    }
    double to_actuator(double joint_rad) const { return zero_rad + joint_rad * direction * ratio; }
    actuator::Command to_actuator(const actuator::Command& command) const;
    /// `signed_current`: the device measures it with a sign.
    actuator::State to_joint(const actuator::State& state, bool signed_current) const;
    actuator::Capabilities to_joint(const actuator::Capabilities& can) const;
};

} // namespace sinew::robot
