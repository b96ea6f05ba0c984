#include "apps/cli/supervised.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/robot_record.hpp"
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
      answered_at_(session.clock().now()), looked_at_(answered_at_), full_at_(answered_at_ + between_full_)
{
    // Some devices tell their current in full looks only, and one that lasts for so long is too much.
    if (guard_.rules().limits.current_max_a)
        between_full_ = Supervisor::lasting / 2;
    guard_.begin(state(), answered_at_);
}

actuator::State Supervised::state() const
{
    return mounting_of(driven_.device.joint).to_joint(driven_.state, driven_.driver->capabilities().current_has_sign);
}

std::expected<void, Error> Supervised::judge(Duration interval)
{
    const TimePoint now = session_.clock().now();
    // A command is renewed by whoever looks.
    const auto found = guard_.judge(state(), running_, now, is_missing() ? answered_at_ : now, interval, now);
    return found.measure == robot::Measure::none ? std::expected<void, Error>{} : named(found.why);
}

std::expected<void, Error> Supervised::send(const actuator::Command& command)
{
    if (is_missing())
        return {};
    if (!has_sent_)
        if (auto fine = judge({}); !fine)
            return fine;
    const TimePoint now = session_.clock().now();
    auto admitted = guard_.admit(command, state(), now);
    if (!admitted)
        return named(admitted.error());
    if (!driven_.driver->capabilities().velocity_limit && admitted->mode == actuator::Mode::position)
        admitted->velocity_rad_s = command.velocity_rad_s; // a leap has no speed that such a device could keep to
    return begin(*admitted);
}

std::expected<void, Error> Supervised::search(double velocity_rad_s)
{
    if (auto fine = judge({}); !fine)
        return fine;
    guard_.watch_place(false);
    return begin({.mode = actuator::Mode::velocity, .velocity_rad_s = velocity_rad_s});
}

void Supervised::rests()
{
    running_ = {.mode = actuator::Mode::hold};
    missing_since_.reset();
    unheard_.reset();
    answered_at_ = session_.clock().now();
    guard_.begin(state(), answered_at_);
}

std::expected<void, Error> Supervised::begin(const actuator::Command& command)
{
    const TimePoint now = session_.clock().now();
    const auto requests = plan(driven_, command);
    if (!requests)
        return std::unexpected(requests.error());
    has_sent_ = true;
    running_ = command;
    if (command.mode == actuator::Mode::position)
        guard_.sent(*command.position_rad, now);
    unheard_.reset();
    if (driven_.record != nullptr)
        driven_.record->told(command);
    return tell(*requests);
}

std::expected<void, Error> Supervised::tell(const wire::Requests& requests)
{
    const TimePoint asked = session_.clock().now();
    auto told = carry_out(driven_, requests);
    if (told || !may_pass(told.error().code))
        return told;
    missing_since_ = asked;
    unheard_ = Unheard{requests, unheard_ ? unheard_->since : asked};
    return {};
}

/// Who was away for long may have lost his supply, and where he is now he is not to leap from.
std::expected<void, Error> Supervised::answers_again()
{
    if (!missing_since_)
        return {};
    const Duration silence = session_.clock().now() - *missing_since_;
    missing_since_.reset();
    if (silence <= robot::doubtful_silence)
        return {};
    return fail(Errc::timeout,
                fmt::format("{} gave no answer for {:.2f} s and may have lost its supply meanwhile; is a plug loose?",
                            driven_.device.name, seconds(silence)));
}

std::expected<void, Error> Supervised::tell_again()
{
    if (!unheard_)
        return {};
    const auto told = carry_out(driven_, unheard_->requests);
    if (told)
        unheard_.reset();
    else if (!may_pass(told.error().code) || session_.clock().now() - unheard_->since > guard_.rules().silence_max)
        return told;
    return {};
}

double Supervised::nearest_step_rad(double position_rad) const
{
    return guard_.nearest_step_rad(position_rad, session_.clock().now());
}

std::expected<void, Error> Supervised::look()
{
    const TimePoint now = session_.clock().now();
    const bool full = now >= full_at_;
    const auto read = read_state(driven_, full ? actuator::Depth::full : actuator::Depth::motion);
    if (!read && !may_pass(read.error().code))
        return read;
    if (!read)
        missing_since_ = missing_since_.value_or(now);
    else if (auto back = answers_again(); !back)
        return back;
    else if (auto told = tell_again(); !told)
        return told;
    if (read)
        answered_at_ = session_.clock().now();
    if (read && full)
        full_at_ = now + between_full_;
    const Duration interval = now - looked_at_;
    looked_at_ = now;
    const auto seen = state();
    if (seen.position_rad && running_.mode != actuator::Mode::position)
        guard_.follow(*seen.position_rad, now);
    guard_.observe(seen);
    return judge(interval);
}

Outcome stopped_for(Session& session, Driven& driven, const Error& why, Otherwise otherwise,
                    const std::function<void()>& before_words)
{
    if (why.code != Errc::out_of_range) {
        Outcome held = held_after(session, driven, why, otherwise);
        if (before_words)
            before_words();
        return held;
    }
    const auto rest = come_to_rest(session, driven, otherwise);
    if (before_words)
        before_words();
    if (!rest)
        return fail(rest.error().code, fmt::format("{}; and {}", to_sentence(why), to_sentence(rest.error())));
    const auto says = says_of(driven, *rest);
    fmt::print(stderr, "sinew: {}; it was stopped at {}{}{}\n", to_sentence(why), place_of(driven),
               says.empty() ? "" : ", and ", says);
    return exit_at_limit;
}

} // namespace sinew::cli
