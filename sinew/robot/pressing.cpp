#include "sinew/robot/pressing.hpp"

#include "sinew/base/units.hpp"
#include "sinew/robot/drive.hpp"

#include <cmath>

namespace sinew::robot {
namespace {

constexpr double standing_rad_s = 0.02; ///< an RMD tells whole degrees per second
constexpr double there_rad = units::rad(0.1);
/// A velocity that is so much older than the position may be another one by now.
constexpr Duration old = std::chrono::milliseconds{30};
/// Of a bus that is read ten times a second there is one from before a look.
constexpr Duration long_ago = std::chrono::milliseconds{250};

} // namespace

bool stands(const actuator::State& state, TimePoint now)
{
    const auto& velocity = state.velocity_rad_s;
    return velocity && std::abs(*velocity) < standing_rad_s && now - velocity.at() <= long_ago &&
           (!state.position_rad || state.position_rad.at() - velocity.at() <= old);
}

bool presses(const actuator::Command& told, const actuator::State& state, TimePoint now)
{
    if (!stands(state, now))
        return false;
    if (told.mode == actuator::Mode::position)
        return state.position_rad && std::abs(*told.position_rad - *state.position_rad) > there_rad;
    return sense_of(told) != 0.0;
}

std::expected<wire::Requests, Error> plan_hold_anew(actuator::Driver& driver, const actuator::State& state, bool looks)
{
    auto out = driver.plan({.mode = actuator::Mode::release}, state);
    if (!out)
        return out;
    const actuator::Command still{.mode = actuator::Mode::hold};
    const auto hold = looks ? driver.plan_cycle(still, state) : driver.plan(still, state);
    if (!hold)
        return hold;
    for (const auto& request : hold->all())
        out->add(request);
    return out;
}

} // namespace sinew::robot
