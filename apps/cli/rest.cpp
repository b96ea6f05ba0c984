#include "apps/cli/rest.hpp"

#include "apps/cli/exit_codes.hpp"
#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration between_looks = std::chrono::milliseconds(100);
constexpr Duration longest_look = std::chrono::seconds(2);
constexpr int looks_until_it_is_told_again = 4;
constexpr int attempts = 3; ///< at a hold or a release that is not confirmed

std::expected<Rest, Error> tell(Driven& driven, Otherwise otherwise)
{
    auto held = hold(driven);
    for (int again = 1; !held && may_pass(held.error().code) && again < attempts; ++again)
        held = hold(driven);
    if (held)
        return Rest::holds;
    if (otherwise == Otherwise::nothing)
        return std::unexpected(held.error());
    const auto released = let_go(driven);
    return released ? std::expected<Rest, Error>(Rest::released) : std::unexpected(released.error());
}

/// What was refused once is refused again; what was not heard, or not sent for want of a link, is not.
bool is_worth_another(const std::expected<Rest, Error>& told)
{
    return told || may_pass(told.error().code) || told.error().code == Errc::link_lost;
}

/// Lost links come back meanwhile.
void pause(Session& session)
{
    const auto buses = session.buses();
    for (const TimePoint next = session.clock().now() + between_looks;
         !interrupted() && session.clock().now() < next;) {
        for (auto* bus : buses)
            bus->tend();
        session.clock().wait({}, next);
    }
}

std::unexpected<Error> not_at_rest(const Driven& driven, const std::expected<Rest, Error>& told)
{
    if (!told)
        return fail(told.error().code, fmt::format("{} did not confirm that it holds, so it may still turn: {}",
                                                   driven.device.name, to_sentence(told.error())));
    if (interrupted())
        return fail(Errc::stopped, fmt::format("{} was told to {}, and nobody waited for it to stand still",
                                               driven.device.name, *told == Rest::holds ? "hold" : "let go"));
    return fail(Errc::timeout, fmt::format("{} was told to {}, but was not seen to stand still; switch its supply off "
                                           "if it turns on",
                                           driven.device.name, *told == Rest::holds ? "hold" : "let go"));
}

/// `told` is called as soon as the first command is out.
template <class Told>
std::expected<Rest, Error> bring_to_rest(Session& session, Driven& driven, Otherwise otherwise, const Told& told)
{
    const Undisturbed undisturbed;
    auto rest = tell(driven, otherwise);
    told();
    const double flicker_rad = driven.driver->capabilities().position_step_rad;
    const TimePoint end = session.clock().now() + longest_look;
    std::optional<double> before;
    for (int look = 1; is_worth_another(rest) && !interrupted(); ++look) {
        (void)read_state(driven, actuator::Depth::motion);
        const auto here = driven.state.position_rad.optional();
        if (rest && here && before && std::abs(*here - *before) <= flicker_rad)
            return rest;
        before = here;
        if (session.clock().now() >= end)
            break;
        if (!rest || look % looks_until_it_is_told_again == 0)
            rest = tell(driven, otherwise);
        pause(session);
    }
    return not_at_rest(driven, rest);
}

} // namespace

std::expected<Rest, Error> come_to_rest(Session& session, Driven& driven, Otherwise otherwise)
{
    return bring_to_rest(session, driven, otherwise, [] {});
}

std::expected<void, Error> let_go(Driven& driven)
{
    const Undisturbed undisturbed;
    const auto requests = driven.driver->plan({.mode = actuator::Mode::release}, {});
    if (!requests)
        return std::unexpected(requests.error());
    auto released = carry_out(driven, *requests);
    for (int again = 1; !released && may_pass(released.error().code) && again < attempts; ++again)
        released = carry_out(driven, *requests);
    return released;
}

std::string says_of(const Driven& driven, Rest rest)
{
    return rest == Rest::holds ? std::string{}
                               : fmt::format("{} took no hold, so its torque is off", driven.device.name);
}

std::unexpected<Error> held_after(Session& session, Driven& driven, Error why, Otherwise otherwise)
{
    const auto rest = come_to_rest(session, driven, otherwise);
    const std::string more = rest ? says_of(driven, *rest) : to_sentence(rest.error());
    if (!more.empty())
        why = Error{.code = why.code, .detail = fmt::format("{}; and {}", to_sentence(why), more)};
    return std::unexpected(std::move(why));
}

Outcome stop_here(Session& session, Driven& driven, Otherwise otherwise)
{
    using Stopped = robot::StoppedBus::Outcome;
    auto* guardian = session.guardian();
    if (was_suspension())
        fmt::print(stderr, "A program that is suspended cannot stop its motor, so it is stopped and this ends.\n");
    const Undisturbed undisturbed;
    const auto rest = bring_to_rest(session, driven, otherwise, [&] {
        if (guardian != nullptr)
            guardian->stop_begun();
    });
    if (guardian != nullptr && guardian->stop_asked()) {
        guardian->stopped(0, rest ? Stopped::confirmed : Stopped::failed,
                          rest ? "" : "not confirmed by " + driven.device.name);
        guardian->stop_done();
    }
    if (!rest && rest.error().code != Errc::stopped)
        return std::unexpected(rest.error());
    if (!rest)
        fmt::print(stderr, "Stopped: {}.\n", to_sentence(rest.error()));
    else if (*rest == Rest::holds)
        fmt::print(stderr, "Stopped; it holds at {:.2f} deg.\n", units::deg(position_of(driven)));
    else
        fmt::print(stderr, "Stopped at {:.2f} deg; {}.\n", units::deg(position_of(driven)), says_of(driven, *rest));
    return exit_interrupted;
}

} // namespace sinew::cli
