#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/families.hpp"

/// A motor with a loop of its speed that is blocked has gathered all the torque that it may. Told to hold, it is where
/// it should be and as fast as it should be, so nothing takes that away: what it pinches stays pinched. This is the one
/// place that says who is taken for that, and what is done about it. In the units of the actuator.
///
/// Only an RMD is let go, by a current of nothing: it stays on, keeps the turns that it has counted, needs no more than
/// the next command to hold, and acknowledges every frame of that. On a bus where the first of these answers is lost
/// the second frame waits for its time-out, 30 ms at first and at most 120 ms (`bus::Settings`): so long a load falls.
/// A Nuri could only be switched off, which nobody acknowledges and which is kept in flash, and a SAM holds by the
/// error of its position alone. A guardian does not do it, for it has nobody to ask.
namespace sinew::robot {

bool can_be_relieved(const DeviceSpec& device);

/// Whether one that was told this may press on something: it is not where it was sent, or is to turn, and is not seen
/// to turn, or only at less than half of the speed that it was told, as one does that squeezes something soft. So may
/// one of which nobody knows whether it turns, and one that takes no current yet: its loop gathers it.
bool presses(const DeviceSpec& device, const actuator::Command& told, const actuator::State& state, TimePoint now);

/// Whether one that was told this is driven on, and turns for all that is known: it may meet something before it holds.
bool may_meet_something(const DeviceSpec& device, const actuator::Command& told, const actuator::State& state,
                        TimePoint now);

/// Whether one that turned when it was told to hold presses on something now that it stands: it takes another current
/// than before. What only carries a load takes the same, but for its friction. Where one of them is not known it may.
bool has_met_something(const actuator::Measured<double>& before_a, const actuator::Measured<double>& now_a);

/// For those who do not know what it was told: whatever is not seen to turn may, but for what is seen to take no
/// current.
bool may_press(const DeviceSpec& device, const actuator::State& state, TimePoint now);

/// What makes it hold with loops that start anew: it is driven with nothing, and told to hold in the next frame. A load
/// comes down by what it falls in the time of a few frames, and by what the new loop needs to take it up. `looks`: and
/// says where it is.
std::expected<wire::Requests, Error> plan_hold_anew(actuator::Driver& driver, const actuator::State& state,
                                                    bool looks = false);

} // namespace sinew::robot
