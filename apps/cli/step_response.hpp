#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/sim/firmware/device.hpp"

#include <array>
#include <expected>
#include <optional>
#include <string>
#include <vector>

/// What a simulated joint does when it is sent somewhere at once.
namespace sinew::cli {

/// One look at the joint, in its own units: behind direction, zero and ratio.
struct StepSample {
    double time_s = 0.0; ///< since the command went out
    double position_rad = 0.0;
    double velocity_rad_s = 0.0;
    double current_a = 0.0; ///< of the winding, in the sense of the actuator
};

struct StepRequest {
    std::string joint;
    double to_rad = 0.0;
    std::optional<double> from_rad{}; ///< where the joint stands at power-on; else where its file says
    Duration length{};
    std::optional<std::array<std::uint8_t, 3>> gains{}; ///< P, I and D of a SAM
};

/// Samples one millisecond apart, the first of the moment when the command goes out. From the first tick until then the
/// joint is held, so that no load moves it. `unknown_name` suggests the nearest; `out_of_range` for a target outside
/// the joint's limits; `unsupported` for gains of a family that has none.
std::expected<std::vector<StepSample>, Error> step_response(config::RobotFile file, const StepRequest& request);

/// What people call a step response good or bad by. The step is from the first sample to the target.
struct StepFigures {
    std::optional<double> rise_time_s;     ///< from 10 % to 90 % of the step; nothing: it does not get there
    double overshoot = 0.0;                ///< beyond the target, as a share of the step
    std::optional<double> settling_time_s; ///< after it, never more than 2 % of the step off the target
    double steady_error_rad = 0.0;         ///< target minus position, mean of the last tenth
    double peak_current_a = 0.0;           ///< without sign
};

/// `samples` must not be empty, and must not begin at the target.
StepFigures figures_of(const std::vector<StepSample>& samples, double target_rad);

} // namespace sinew::cli
