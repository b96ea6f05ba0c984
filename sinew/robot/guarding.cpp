#include "sinew/robot/core.hpp"
#include "sinew/robot/guardian.hpp"

#include <algorithm>
#include <fmt/format.h>

/// What a robot tells its guardian, and what it hears from it.
namespace sinew::robot {
namespace {

constexpr Duration between_beats = std::chrono::milliseconds{20};

/// A guardian cannot look.
StopFrames frames_of(Line& line, Line::Whom whom, TimePoint now)
{
    const auto [seen, until, unseen] = line.blind_stop(whom, now);
    return {.seen = seen, .unseen = unseen, .seen_for = until - now};
}

} // namespace

/// Devices that hold their last target must not be left to a process that no longer has a robot.
Core::~Core()
{
    if (guardian_ != nullptr)
        for (std::size_t i = 0; i < lines.size(); ++i)
            guardian_->forget(i);
    rest();
}

std::expected<void, Error> Core::hand_over(std::size_t line)
{
    auto& bus = lines[line]->bus();
    // What has no descriptor is within this process, and its devices end with it.
    const int handle = std::visit([](const auto& link) { return link->handle(); }, bus.link());
    if (handle < 0 && bus.link_trouble() == nullptr)
        return {};
    const TimePoint now = clock->now();
    lines[line]->prepare_stop(now);
    auto watched = guardian_->watch(line, uris_[line], bus.link(), frames_of(*lines[line], Line::Whom::all, now));
    if (watched)
        known_[line] = bus.losses();
    return watched;
}

std::expected<void, Error> Core::hand_over()
{
    if (guardian_ == nullptr)
        return {};
    known_.resize(lines.size());
    for (std::size_t i = 0; i < lines.size(); ++i)
        if (auto watched = hand_over(i); !watched)
            return watched;
    return {};
}

/// Before anything goes out.
std::expected<void, Error> Core::heed_the_guardian()
{
    if (guardian_ == nullptr)
        return {};
    guardian_->beat();
    if (guardian_->stop_asked()) {
        Error why{.code = Errc::stopped,
                  .detail = "stopped from outside: by sinew stop, or by the guardian of this "
                            "program, which found it hanging"};
        if (enabled)
            return stop_for(std::move(why));
        (void)stop(to_sentence(why));
    }
    if (enabled && !guardian_->is_alive())
        return stop_for({.code = Errc::stopped,
                         .detail = "the guardian of this program was killed; nothing would stop the motors if the "
                                   "program died"});
    return {};
}

void Core::tell_the_guardian(Line& line)
{
    if (guardian_ == nullptr)
        return;
    const auto at = static_cast<std::size_t>(
        std::ranges::find(lines, &line, [](const auto& one) { return one.get(); }) - lines.begin());
    if (at >= known_.size() || !known_[at])
        return;
    if (lines[at]->is_lost()) {
        guardian_->forget(at);
        known_[at].reset();
    } else {
        const auto whom = enabled || line.owes_stop() ? Line::Whom::all : Line::Whom::owing;
        guardian_->update(at, lines[at]->bus().link(), frames_of(line, whom, clock->now()));
    }
}

/// In everything that takes time, so that no long call of the robot itself counts as a program that hangs; nor does one
/// whose stop was on its way already when somebody asked for one.
void Core::show_life()
{
    if (guardian_ == nullptr)
        return;
    guardian_->beat();
    if (is_stopping_)
        guardian_->stop_begun();
}

/// Until the exchanges of all buses have ended: long, where many devices answer nothing.
void Core::drive()
{
    if (guardian_ == nullptr) {
        bus::drive(buses);
        return;
    }
    while (!bus::drive(buses, clock->now() + between_beats))
        show_life();
}

/// A robot that is stopped has nothing to be late with.
void Core::rest()
{
    if (guardian_ != nullptr)
        guardian_->rest();
}

void Core::tell_the_guardian_of_a_stop(std::span<const Stopped> outcomes)
{
    if (guardian_ == nullptr || !guardian_->stop_asked())
        return;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        auto outcome = StoppedBus::Outcome::confirmed;
        std::string failures;
        for (const Stopped& one : outcomes) {
            if (std::ranges::find(lines[i]->joints(), one.joint, &Joint::name) == lines[i]->joints().end())
                continue;
            if (one.outcome == Stopped::Outcome::failed)
                failures.append(failures.empty() ? "" : ", ").append(one.joint);
            else if (one.outcome == Stopped::Outcome::sent && outcome == StoppedBus::Outcome::confirmed)
                outcome = StoppedBus::Outcome::sent;
        }
        if (lines[i]->bus().link_trouble() != nullptr)
            failures = "its link is lost";
        else if (!failures.empty())
            failures.insert(0, "not confirmed by ");
        guardian_->stopped(i, failures.empty() ? outcome : StoppedBus::Outcome::failed, failures);
    }
    guardian_->stop_done();
}

} // namespace sinew::robot
