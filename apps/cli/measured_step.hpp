#pragma once
#include "apps/cli/step_response.hpp"
#include "apps/cli/supervised.hpp"

namespace sinew::cli {

/// Sends a device to `to_rad` (of the joint) at once and looks at it as often as its bus allows for `length`. The first
/// sample is where it stood before; velocities that the device does not tell are differences of positions. Ends early,
/// with what there is, when it is interrupted; an error of `supervised` ends it too, and leaves the device as it is.
std::expected<std::vector<StepSample>, Error> measured_step(Session& session, Driven& driven, Supervised& supervised,
                                                            double to_rad, Duration length);

} // namespace sinew::cli
