#pragma once
#include "sinew/family/rmd/driver.hpp"

#include <span>

namespace sinew::rmd {

/// One motor of a torque group.
struct GroupMember {
    Driver* driver = nullptr;
    actuator::Command command; ///< mode current or torque
};

/// The currents of up to four motors with ids 1 to 4 in one frame (0x280), after whatever makes them run. Every motor
/// of the bus with such an id obeys the frame, so the group must hold all of them: one that is left out is driven with
/// no current, whatever it was doing.
///
/// Each motor answers, so that the exchange is over when as many have answered as the group has members, and
/// `Driver::absorb` takes its own answer out of the four. An error with the reason, and nothing planned, where a
/// command is not of these modes or beyond the frame, where a firmware line does not have the message, or where the
/// scale of the frame is not documented: it is printed for motors of 32 A at full scale only (R11).
std::expected<wire::Requests, Error> plan_group(std::span<const GroupMember> members);

} // namespace sinew::rmd
