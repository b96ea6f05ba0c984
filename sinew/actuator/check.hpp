#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/base/error.hpp"

#include <expected>

namespace sinew::actuator {

/// Whether a command makes sense for an actuator with these capabilities: the values its mode needs are there, they are
/// numbers, and they are within what the device can do. `unsupported` or `out_of_range` with the reason.
std::expected<void, Error> check(const Command& command, const Capabilities& can, int id);

} // namespace sinew::actuator
