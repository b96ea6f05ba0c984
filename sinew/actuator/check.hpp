#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/base/error.hpp"

#include <expected>
#include <string>

namespace sinew::actuator {

/// Whether a command makes sense for an actuator with these capabilities: what its mode needs is there and nothing that
/// it does not take, all of it finite numbers, within what the device can do. `missing_field`, `bad_argument`,
/// `unsupported` or `out_of_range` with the reason. Hold and release are always fine.
std::expected<void, Error> check(const Command& command, const Capabilities& can, int id);

/// Whether a command stays within limits, from the state it would begin in. `out_of_range` with the limit; a step limit
/// needs a measured position. Hold, release and brake are always fine. Of a command that `check` above has passed.
std::expected<void, Error> check(const Command& command, const Limits& limits, const State& state, int id);

/// An error of a device in words.
std::unexpected<Error> refuse(Errc code, int id, std::string why);

} // namespace sinew::actuator
