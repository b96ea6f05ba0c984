#include "sinew/robot/pressing.hpp"

#include "sinew/base/units.hpp"
#include "sinew/robot/drive.hpp"
#include "sinew/robot/stillness.hpp"

#include <cmath>

namespace sinew::robot {
namespace {

constexpr double standing_rad_s = 0.02; ///< an RMD tells whole degrees per second: one of them is no motion yet
constexpr double there_rad = units::rad(0.1);
/// Of a bus that is read ten times a second there is one from before a look.
constexpr Duration long_ago = std::chrono::milliseconds{250};

/// GUESS: what friction, and the noise of a current, make of it.
constexpr double another_a = 0.3;
constexpr double another_share = 0.25;

/// Not where that is not known, or was too long ago.
bool turns(const actuator::State& state, TimePoint now)
{
    const auto& velocity = state.velocity_rad_s;
    return velocity && std::abs(*velocity) >= standing_rad_s && now - velocity.at() <= long_ago &&
           (!state.position_rad || state.position_rad.at() - velocity.at() <= old_velocity);
}

/// Its torque is nothing that anybody would feel. GUESS.
constexpr double idle_a = 0.1;

bool is_idle(const actuator::State& state, TimePoint now)
{
    return state.current_a && std::abs(*state.current_a) < idle_a && now - state.current_a.at() <= long_ago;
}

/// It has met what gives way, or it has begun a moment ago; who knows.
constexpr double slow_share = 0.5;

bool is_slow(const actuator::Command& told, const actuator::State& state)
{
    return told.velocity_rad_s && std::abs(*state.velocity_rad_s) < slow_share * std::abs(*told.velocity_rad_s);
}

bool drives(const actuator::Command& told, const actuator::State& state)
{
    if (told.mode == actuator::Mode::position)
        return !state.position_rad || std::abs(*told.position_rad - *state.position_rad) > there_rad;
    return sense_of(told) != 0.0;
}

} // namespace

bool can_be_relieved(const DeviceSpec& device)
{
    return std::holds_alternative<rmd::Spec>(device);
}

bool may_press(const DeviceSpec& device, const actuator::State& state, TimePoint now)
{
    return can_be_relieved(device) && !turns(state, now) && !is_idle(state, now);
}

bool presses(const DeviceSpec& device, const actuator::Command& told, const actuator::State& state, TimePoint now)
{
    return can_be_relieved(device) && drives(told, state) && (!turns(state, now) || is_slow(told, state));
}

bool may_meet_something(const DeviceSpec& device, const actuator::Command& told, const actuator::State& state,
                        TimePoint now)
{
    return can_be_relieved(device) && turns(state, now) && drives(told, state);
}

bool has_met_something(const actuator::Measured<double>& before_a, const actuator::Measured<double>& now_a)
{
    if (!before_a || !now_a)
        return true;
    return std::abs(*now_a - *before_a) > another_a + another_share * std::abs(*before_a);
}

std::expected<wire::Requests, Error> plan_hold_anew(actuator::Driver& driver, const actuator::State& state, bool looks)
{
    wire::Requests out;
    if (const auto idle = driver.plan_idle()) // else it can only be told to hold
        out = *idle;
    const actuator::Command still{.mode = actuator::Mode::hold};
    const auto hold = looks ? driver.plan_cycle(still, state) : driver.plan(still, state);
    if (!hold)
        return hold;
    for (const auto& request : hold->all())
        out.add(request);
    return out;
}

} // namespace sinew::robot
