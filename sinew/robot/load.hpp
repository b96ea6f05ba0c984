#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/bus/predict.hpp"
#include "sinew/config/robot_file.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace sinew::robot {

/// What a robot sends on one of its buses, from the same functions as its cycles and its stops.
struct Load {
    struct Part {
        std::string joint; ///< "all" of a message to all devices of the line
        wire::Request request;
    };
    std::vector<Part> cycle; ///< a position for every joint, and what it measures
    /// All that a cycle may carry: commands of every kind, settings, and what is read now and then.
    std::vector<Part> most;
    std::vector<Part> stop;         ///< that which takes longest: of joints that move, are silent, or were let go
    std::vector<std::string> notes; ///< joints that cannot be sent to a position, and why
};

/// Nothing is opened. `bad_file` as the robot has it. `line` is the wire, to tell which stop takes longest.
std::expected<Load, Error> load_of(const config::RobotFile& file, std::string_view bus, const bus::Line& line);

/// Some drivers have to ask a device for a setting, or where it is, once. Zeros for an answer bring them to what they
/// plan from then on.
void settle(actuator::Driver& driver, actuator::State& state, TimePoint at = {});

} // namespace sinew::robot
