#pragma once
#include "apps/cli/json.hpp"
#include "apps/cli/session.hpp"
#include "sinew/robot/mounting.hpp"

/// Joint units: those of the output behind the direction, zero and ratio of the robot file. A device named by its link
/// is its own joint.
namespace sinew::cli {

robot::Mounting mounting_of(const config::Joint* joint);
double to_joint_position(const config::Joint* joint, double actuator_rad);
double to_joint_velocity(const config::Joint* joint, double actuator_rad_s);
double to_actuator_position(const config::Joint* joint, double joint_rad);

/// The position of the joint that was read last; nothing where that look measured none.
std::optional<double> position_of(const Driven& driven);
/// The same for a person, in degrees.
std::string place_of(const Driven& driven);
/// The same for what cannot be done without: `bad_reply` where that look measured none.
std::expected<double, Error> known_position_of(const Driven& driven);
/// The same for a move, which cannot begin further out than the actuator reaches: `out_of_range`.
std::expected<double, Error> start_of(const Driven& driven);

/// The requests that carry out a command in joint units.
std::expected<wire::Requests, Error> plan(Driven& driven, const actuator::Command& command);
/// A move in joint units. The limit of the robot file is also the speed of one that names none, where the device takes
/// a speed.
actuator::Command move_to_position(const Driven& driven, double position_rad, std::optional<double> speed_rad_s = {});

/// The limits of the robot file: `out_of_range` with the limit in degrees.
std::expected<void, Error> check_limits(const Device& device, double position_rad, std::optional<double> speed_rad_s);

/// The state as an object with SI names, such as position_rad; what was not measured is null.
Json state_json(const Driven& driven, Duration since_start);

/// Position, velocity, current, voltage, temperature and faults, for a row of a table; empty where not measured.
std::vector<std::string> state_cells(const Driven& driven);
inline const std::vector<std::string> state_head{"POSITION", "SPEED", "CURRENT", "VOLTAGE", "TEMP", "FAULTS"};

/// An angle such as 90deg, 1.57rad or 0.25turn.
std::expected<double, Error> angle_from(std::string_view word);
/// A positive angular speed such as 30deg/s, 1rad/s or 10rpm.
std::expected<double, Error> speed_from(std::string_view word);

} // namespace sinew::cli
