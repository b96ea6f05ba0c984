#pragma once
#include "sinew/actuator/driver.hpp"

namespace sinew::robot {

/// How a device is kept from moving when nobody knows where its shaft is: it holds, or, where it must be told the place
/// (SAM), it brakes. At a place that is old it would arrive with all its torque. Asks the heap.
inline actuator::Mode hold_unseen(actuator::Driver& driver)
{
    const bool needs_a_place = !driver.plan({.mode = actuator::Mode::hold}, {});
    return needs_a_place && driver.capabilities().brake ? actuator::Mode::brake : actuator::Mode::hold;
}

} // namespace sinew::robot
