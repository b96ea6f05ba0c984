#include "apps/cli/rest.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/robot_record.hpp"
#include "sinew/robot/hold_unseen.hpp"
#include "sinew/robot/pressing.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace sinew::cli {
namespace {

constexpr int looks_until_it_is_told_again = 4;

/// Undisturbed; and a Ctrl-C that nobody has seen yet is kept for who asks next.
class InterruptKept
{
public:
    InterruptKept() = default;
    ~InterruptKept()
    {
        if (came_before_)
            interrupt();
    }
    InterruptKept(const InterruptKept&) = delete;
    InterruptKept& operator=(const InterruptKept&) = delete;

private:
    bool came_before_ = interrupted();
    Undisturbed undisturbed_;
};

std::expected<void, Error> carry_out_planned(Driven& driven, const std::expected<wire::Requests, Error>& planned)
{
    return planned ? carry_out(driven, *planned) : std::unexpected(planned.error());
}

void note(const Driven& driven, actuator::Mode told)
{
    if (driven.record != nullptr)
        driven.record->told({.mode = told});
}

Telling tell(Driven& driven, Otherwise otherwise, std::optional<double> last = {})
{
    Telling told{.place_rad = last};
    told.confirmed = until_confirmed([&] {
        told = tell_to_hold(driven, told.place_rad);
        return told.confirmed;
    });
    // A brake that nobody acknowledged may be on; letting go would undo it.
    const bool may_brake = told.rest == Rest::braked && (told.confirmed || may_pass(told.confirmed.error().code));
    if (told.confirmed || may_brake || otherwise == Otherwise::nothing)
        return told;
    return {Rest::released, let_go(driven)};
}

/// What was refused once is refused again; what was not heard, or not sent for want of a link, is not.
bool is_worth_another(const Telling& told)
{
    return told.confirmed || may_pass(told.confirmed.error().code) || told.confirmed.error().code == Errc::link_lost;
}

/// Lost links come back meanwhile.
void pause(Session& session)
{
    const auto buses = session.buses();
    for (const TimePoint next = session.clock().now() + between_looks;
         !interrupted() && session.clock().now() < next;) {
        if (auto* guardian = session.guardian())
            guardian->beat();
        for (auto* bus : buses)
            bus->tend();
        session.clock().wait({}, next);
    }
}

std::unexpected<Error> not_at_rest(const Driven& driven, const Telling& told)
{
    if (!told.confirmed)
        return fail(told.confirmed.error().code,
                    fmt::format("{} was told to {} and did not confirm that, so it may still turn{}: {}",
                                driven.device.name, to_verb(told.rest), told.rest == Rest::holds ? " or be free" : "",
                                to_sentence(told.confirmed.error())));
    if (interrupted())
        return fail(Errc::stopped, fmt::format("{} was told to {}, and nobody waited for it to stand still",
                                               driven.device.name, to_verb(told.rest)));
    return fail(Errc::timeout, fmt::format("{} was told to {}, but was not seen to stand still; switch its supply off "
                                           "if it turns on",
                                           driven.device.name, to_verb(told.rest)));
}

/// Who asked for a stop learns that the frames are out, also where it was asked for while the motor is looked at.
void say_that_it_is_told(Session& session)
{
    if (auto* guardian = session.guardian(); guardian != nullptr && guardian->stop_asked())
        guardian->stop_begun();
}

/// `told`: what it was told last.
std::expected<Rest, Error> bring_to_rest(Session& session, Driven& driven, Otherwise otherwise, Telling& told)
{
    bool presses = may_press(driven);
    const auto before_a = driven.state.current_a;
    int reliefs = 0;
    told = tell(driven, otherwise);
    Standing standing(driven);
    TimePoint end = session.clock().now() + robot::longest_rest;
    bool was_seen_at_rest = false;
    for (int look = 1; is_worth_another(told) && !interrupted(); ++look) {
        if (told.confirmed)
            say_that_it_is_told(session);
        (void)read_state(driven, actuator::Depth::motion);
        standing.look(driven);
        if (told.confirmed && standing.is_at_rest()) {
            if (!std::exchange(was_seen_at_rest, true) && !presses)
                presses = may_press(driven) && robot::has_met_something(before_a, driven.state.current_a);
            if (told.rest != Rest::holds || !presses)
                return told.rest;
            if (reliefs++ == most_reliefs)
                return fail(Errc::timeout, fmt::format("{} {}", driven.device.name, may_press_on));
            presses = !hold_anew(driven, told);
            standing = Standing(driven);
            end = std::max(end, session.clock().now() + robot::rest_after_relief);
        }
        if (session.clock().now() >= end)
            break;
        if (!told.confirmed || told.rest == Rest::braked || look % looks_until_it_is_told_again == 0)
            told = tell(driven, otherwise, told.place_rad);
        pause(session);
    }
    return not_at_rest(driven, told);
}

} // namespace

std::string_view to_verb(Rest rest)
{
    return rest == Rest::holds ? "hold" : rest == Rest::braked ? "brake" : "release";
}

Standing::Standing(const Driven& driven)
    : stillness_(mounting_of(driven.device.joint).to_joint(driven.driver->capabilities()).position_step_rad)
{
}

void Standing::look(const Driven& driven)
{
    const auto& state = driven.state;
    if (const auto here = position_of(driven))
        stillness_.look({*here, state.position_rad.at()});
    else
        stillness_.begin();
    const bool is_slow = !state.position_rad && state.velocity_rad_s && *state.velocity_rad_s == 0.0;
    slow_looks_ = is_slow ? slow_looks_ + 1 : 0;
}

Telling tell_to_hold(Driven& driven, std::optional<double> last)
{
    const actuator::Command hold{.mode = actuator::Mode::hold};
    auto planned = driven.driver->plan(hold, {});
    std::optional<double> place;
    if (!planned) {
        const auto read = read_state(driven, actuator::Depth::motion);
        actuator::State at = driven.state;
        if (at.position_rad && last && std::abs(*at.position_rad - *last) <= robot::giving_way_rad)
            at.position_rad = *last;
        place = at.position_rad.optional();
        planned = read ? driven.driver->plan(hold, at) : std::unexpected(read.error());
    }
    if (!planned && robot::hold_unseen(*driven.driver) == actuator::Mode::brake) {
        note(driven, actuator::Mode::brake);
        return {Rest::braked, carry_out_planned(driven, driven.driver->plan({.mode = actuator::Mode::brake}, {}))};
    }
    note(driven, actuator::Mode::hold);
    return {Rest::holds, carry_out_planned(driven, planned), place};
}

bool may_press(const Driven& driven)
{
    return robot::may_press(*driven.device.spec, driven.state, driven.bus->clock().now());
}

bool hold_anew(Driven& driven, Telling& told)
{
    const InterruptKept kept;
    note(driven, actuator::Mode::hold);
    told = {Rest::holds, carry_out_planned(driven, robot::plan_hold_anew(*driven.driver, {}))};
    if (told.confirmed)
        return true;
    told = tell(driven, Otherwise::nothing);
    return false;
}

std::expected<Rest, Error> come_to_rest(Session& session, Driven& driven, Otherwise otherwise)
{
    const InterruptKept kept;
    Telling told;
    return bring_to_rest(session, driven, otherwise, told);
}

std::expected<void, Error> let_go(Driven& driven)
{
    const InterruptKept kept;
    const auto requests = driven.driver->plan({.mode = actuator::Mode::release}, {});
    if (!requests)
        return std::unexpected(requests.error());
    note(driven, actuator::Mode::release);
    return until_confirmed([&] { return carry_out(driven, *requests); });
}

std::string says_of(const Driven& driven, Rest rest)
{
    if (rest == Rest::holds)
        return {};
    return fmt::format("{} {}", driven.device.name,
                       rest == Rest::braked ? "did not say where it was to hold, so it is only braked"
                                            : "took no hold, so its torque is off");
}

std::unexpected<Error> held_after(Session& session, Driven& driven, const Error& why, Otherwise otherwise)
{
    const auto rest = come_to_rest(session, driven, otherwise);
    const std::string said = to_sentence(why);
    if (rest && *rest == Rest::holds)
        return fail(why.code,
                    fmt::format("{}{} is held at {}", said, said.ends_with('?') ? " It" : "; it", place_of(driven)));
    return fail(why.code, fmt::format("{}; and {}", said, rest ? says_of(driven, *rest) : to_sentence(rest.error())));
}

Outcome stop_here(Session& session, Driven& driven, Otherwise otherwise, const std::function<void()>& before_words)
{
    using Stopped = robot::StoppedBus::Outcome;
    auto* guardian = session.guardian();
    const Undisturbed undisturbed;
    Telling told;
    const auto rest = bring_to_rest(session, driven, otherwise, told);
    // What was not obeyed is not called done: then the guardian sends its own.
    if (guardian != nullptr && guardian->stop_asked() && told.confirmed) {
        guardian->stopped(0, rest ? Stopped::confirmed : Stopped::failed,
                          rest ? "" : "not confirmed by " + driven.device.name);
        guardian->stop_done();
    }
    // Not before: a terminal that is gone, or takes nothing, must not keep the motor from being stopped.
    if (before_words)
        before_words();
    if (was_suspension())
        tell_of_suspension();
    if (!rest && rest.error().code != Errc::stopped)
        return std::unexpected(rest.error());
    if (!rest)
        fmt::print(stderr, "Stopped: {}.\n", to_sentence(rest.error()));
    else if (*rest == Rest::holds)
        fmt::print(stderr, "Stopped; it holds at {}.\n", place_of(driven));
    else
        fmt::print(stderr, "Stopped at {}; {}.\n", place_of(driven), says_of(driven, *rest));
    return exit_interrupted;
}

} // namespace sinew::cli
