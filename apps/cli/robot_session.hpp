#pragma once
#include "apps/cli/verb.hpp"
#include "sinew/link/clock.hpp"
#include "sinew/link/links.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"

#include <memory>

namespace sinew::cli {

/// The options of verbs that drive a whole robot.
std::vector<Option> with_robot_options(std::vector<Option> before);

/// The robot file that the options name. `bad_argument` where they name none.
std::expected<config::RobotFile, Error> robot_file(const Words& words);

/// A whole robot for one run of the command: its links, its time, and a guardian that stops it when the command dies or
/// hangs. A robot that is simulated in here has none, for nothing outlives its program.
class RobotSession
{
public:
    /// Opens all buses; sends nothing. From now on Ctrl-C only sets a flag (see interrupt.hpp).
    static std::expected<std::unique_ptr<RobotSession>, Error> open(const Words& words, config::RobotFile file);

    robot::Robot& robot() { return *robot_; }
    /// What happened that nobody asked for, once, on stderr.
    void tell_incidents();

private:
    RobotSession();

    link::RealClock real_;
    sim::Worlds worlds_; // goes after the links that lead into it
    link::Links links_;
    std::optional<robot::Guardian> guardian_;
    std::optional<robot::Robot> robot_;
    std::uint64_t told_ = 0; ///< incidents, since the robot was opened
};

} // namespace sinew::cli
