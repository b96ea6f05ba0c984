#pragma once
#include "sinew/base/units.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/robot/supervisor.hpp"

namespace sinew::robot {

/// By how much a control loop of position gives way to a load (4 deg to half of its torque, with the gains of
/// delivery).
inline constexpr double giving_way_rad = units::rad(5.0);

/// A device that gave no answer for so long may have lost its supply meanwhile, which nothing that it says could show.
inline constexpr Duration doubtful_silence = std::chrono::milliseconds{100};

/// Where it was is no place to hold after so long, however seldom it is looked at.
inline constexpr Duration longest_trust = std::chrono::seconds{1};

/// What a robot file holds a joint to: its own limits, else those of `[safety]`. `can`: what the joint
/// can, where that is known.
Rules rules_of(const config::Joint& joint, const config::Safety& safety, const actuator::Capabilities& can = {});

} // namespace sinew::robot
