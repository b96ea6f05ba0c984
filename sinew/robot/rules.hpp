#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/robot/supervisor.hpp"

namespace sinew::robot {

/// What a robot file holds a joint to: its own limits, else those of `[safety]`. `can`: what the joint
/// can, where that is known.
Rules rules_of(const config::Joint& joint, const config::Safety& safety, const actuator::Capabilities& can = {});

} // namespace sinew::robot
