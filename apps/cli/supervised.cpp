#include "apps/cli/supervised.hpp"

#include "apps/cli/exit_codes.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

using robot::Supervisor;

constexpr Duration between_full_looks = std::chrono::milliseconds(500);

robot::Rules rules_for(const Driven& driven)
{
    const auto& device = driven.device;
    const auto can = mounting_of(device.joint).to_joint(driven.driver->capabilities());
    return device.joint != nullptr ? robot::rules_of(*device.joint, device.file->safety, can)
                                   : robot::rules_of({}, {}, can);
}

/// Its words have the name of the device; the id beside it says nothing more.
std::unexpected<Error> named(const Error& error)
{
    return fail(error.code, error.detail);
}

Supervisor supervisor_for(const Driven& driven, Reached reached)
{
    const auto& device = driven.device;
    const bool needs_no_steps = driven.driver->capabilities().velocity_limit || reached == Reached::by_a_leap;
    return {device.name, device.id, rules_for(driven), needs_no_steps};
}

} // namespace

Supervised::Supervised(Session& session, Driven& driven, Reached reached)
    : session_(session), driven_(driven), guard_(supervisor_for(driven, reached)), between_full_(between_full_looks),
      placed_at_(session.clock().now()), looked_at_(placed_at_), full_at_(placed_at_ + between_full_)
{
    // Some devices tell their current in full looks only, and one that lasts for so long is too much.
    if (guard_.rules().limits.current_max_a)
        between_full_ = Supervisor::lasting / 2;
    guard_.begin(state(), placed_at_);
}

actuator::State Supervised::state() const
{
    return mounting_of(driven_.device.joint).to_joint(driven_.state, driven_.driver->capabilities().current_has_sign);
}

std::expected<void, Error> Supervised::judge(Duration interval)
{
    const TimePoint now = session_.clock().now();
    const auto& limits = guard_.rules().limits;
    if ((limits.position_low_rad || limits.position_high_rad) && now - placed_at_ > guard_.rules().silence_max)
        return fail(Errc::timeout, fmt::format("{} has not said for {:.2f} s where it is, and its limits need that",
                                               driven_.device.name, seconds(now - placed_at_)));
    // A command is renewed by whoever looks, and a look that is not answered is an error of its own.
    const auto found = guard_.judge(state(), running_, now, now, interval, now);
    return found.measure == robot::Measure::none ? std::expected<void, Error>{} : named(found.why);
}

std::expected<void, Error> Supervised::send(const actuator::Command& command)
{
    if (!has_sent_)
        if (auto fine = judge({}); !fine)
            return fine;
    const TimePoint now = session_.clock().now();
    auto admitted = guard_.admit(command, state(), now);
    if (!admitted)
        return named(admitted.error());
    if (!driven_.driver->capabilities().velocity_limit && admitted->mode == actuator::Mode::position)
        admitted->velocity_rad_s = command.velocity_rad_s; // a leap has no speed that such a device could keep to
    const auto requests = plan(driven_, *admitted);
    if (!requests)
        return std::unexpected(requests.error());
    has_sent_ = true;
    running_ = *admitted;
    if (admitted->mode == actuator::Mode::position)
        guard_.sent(*admitted->position_rad, now);
    return carry_out(driven_, *requests);
}

std::expected<void, Error> Supervised::look()
{
    const TimePoint now = session_.clock().now();
    const bool full = now >= full_at_;
    if (full)
        full_at_ = now + between_full_;
    if (auto read = read_state(driven_, full ? actuator::Depth::full : actuator::Depth::motion); !read)
        return read;
    const Duration interval = now - looked_at_;
    looked_at_ = now;
    const auto seen = state();
    if (seen.position_rad)
        placed_at_ = seen.position_rad.at();
    guard_.observe(seen);
    return judge(interval);
}

Outcome stopped_for(Session& session, Driven& driven, const Error& why, Otherwise otherwise)
{
    if (why.code != Errc::out_of_range)
        return held_after(session, driven, why, otherwise);
    const auto rest = come_to_rest(session, driven, otherwise);
    if (!rest)
        return fail(rest.error().code, fmt::format("{}; and {}", to_sentence(why), to_sentence(rest.error())));
    const auto says = says_of(driven, *rest);
    fmt::print(stderr, "sinew: {}; it was stopped at {}{}{}\n", to_sentence(why), place_of(driven),
               says.empty() ? "" : ", and ", says);
    return exit_at_limit;
}

} // namespace sinew::cli
