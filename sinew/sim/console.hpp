#pragma once
#include "sinew/sim/world.hpp"

#include <expected>
#include <string>
#include <string_view>

namespace sinew::sim {

/// One line typed by a person who looks after a simulated robot, and what to print. Empty for an empty answer.
///
///     look [JOINT…]                     what the devices are doing
///     fault TARGET KIND [KEY=VALUE…]    from now on, or at_s from now
///     mend TARGET                       takes back what hits this joint or bus
///     faults                            the kinds there are
///     help
///
/// `bad_argument`, `unknown_name` with the nearest; then nothing has changed.
std::expected<std::string, Error> respond(World& world, std::string_view line);

} // namespace sinew::sim
