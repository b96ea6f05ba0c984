#pragma once
#include "apps/cli/stopping.hpp"

#include <vector>

namespace sinew::cli {

/// Stops what was asked for by name, and says of each how that ended. A program that holds the port of some of them is
/// told to do it. `whole`: these are all joints of a robot, so that a line may be told as one.
std::vector<Done> stop_devices(Session& session, std::span<const Device> devices, bool whole, bool keep_torque);

} // namespace sinew::cli
