#pragma once
#include "apps/cli/moving.hpp"

namespace sinew::cli {

/// `routine = "stop"` of a joint: turns it slowly until something stops it, takes that for the place that the robot
/// file says, and counts from there on. Nothing: it has found its stop and holds; else the exit code of what ended it.
std::expected<std::optional<int>, Error> find_stop(const Words& words, Session& session, Driven& driven,
                                                   Duration within);

} // namespace sinew::cli
