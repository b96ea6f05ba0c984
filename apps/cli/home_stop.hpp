#pragma once
#include "apps/cli/moving.hpp"

namespace sinew::cli {

/// `routine = "stop"` of a joint: turns it slowly until something stops it, takes that for the place that the robot
/// file says, and counts from there on. Nothing: it has found its stop and holds; else the exit code of what ended it.
/// `timeout`: there was none as far as it may turn, and it was brought to rest.
std::expected<std::optional<int>, Error> find_stop(const Words& words, Session& session, Driven& driven);

} // namespace sinew::cli
