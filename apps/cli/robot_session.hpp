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
/// hangs (for `command_timeout_s`, if that is not too short). A robot that is simulated in here has none, for nothing
/// outlives its program.
class RobotSession
{
public:
    /// Opens all buses; sends nothing. From now on Ctrl-C only sets a flag (see interrupt.hpp).
    static std::expected<std::unique_ptr<RobotSession>, Error> open(const Words& words, config::RobotFile file);

    robot::Robot& robot() { return *robot_; }
    /// What happened that nobody asked for, once, on stderr; but for what `told`, an error that is told elsewhere,
    /// says.
    void tell_incidents(const Error* told = nullptr);
    /// Whether one of those says the same as this error.
    bool has_told(const Error& error) const;

private:
    RobotSession();
    /// That of all of them: `bad_argument` for one in virtual time beside a real one.
    std::expected<link::Clock*, Error> clock_for(const std::vector<std::string>& links);

    link::RealClock real_;
    sim::Worlds worlds_; // goes after the links that lead into it
    link::Links links_;
    std::optional<robot::Guardian> guardian_;
    std::optional<robot::Robot> robot_;
    std::uint64_t told_ = 0; ///< incidents, since the robot was opened
};

} // namespace sinew::cli
