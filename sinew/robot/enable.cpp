#include "sinew/robot/core.hpp"
#include "sinew/robot/identity.hpp"
#include "sinew/robot/pressing.hpp"
#include "sinew/wire/by_name.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

/// From whatever the devices were doing to joints that hold where they are.
namespace sinew::robot {
namespace {

using Planned = std::expected<wire::Requests, Error>;

constexpr int times_to_believe = 3;

/// What makes a device obey that may have been switched off before. The hold before it is what it then obeys. A Nuri's
/// hold has that in it where it says that it is off: its switch is in its flash.
Planned plan_switch_on(const DeviceSpec& device)
{
    wire::Requests out;
    if (!std::holds_alternative<rmd::Spec>(device) || line_of(device).find("motor-running") == nullptr)
        return out;
    if (const auto request = wire::make_request(line_of(device), "motor-running", id_of(device), {}, options_of(device),
                                                response_time_of(device)))
        out.add(*request);
    return out;
}

} // namespace

/// What was stopped while its link was lost, if that is back.
void Core::tell_owed_stop(Line& line)
{
    auto& bus = line.bus();
    if (!line.owes_stop())
        return;
    line.prepare_stop(clock->now());
    bus.set_stop(line.unseen_stop_requests()); // where its shafts are now is not known, though one may have answered
    bus.request_stop();
    if (bus.link_trouble() == nullptr)
        drive();
    if (bus.link_trouble() != nullptr)
        return; // it goes out when that is back
    line.close_stop();
}

/// Who is back hears of his stop before anybody waits for the others. The first that is not back, after all had their
/// turn.
std::expected<void, Error> Core::bring_links_back()
{
    for (auto& line : lines) {
        line->bus().clear_stop();
        (void)line->bus().tend();
        tell_owed_stop(*line);
    }
    std::expected<void, Error> all;
    const TimePoint patience = clock->now() + std::chrono::milliseconds{300};
    for (auto& line : lines) {
        auto& bus = line->bus();
        bus.clear_stop(); // nobody waits for a link while a stop is asked for
        if (bus.link_trouble() != nullptr)
            (void)bus.wait_for_link(patience);
        tell_owed_stop(*line);
        if (bus.link_trouble() == nullptr)
            line->forgive();
        else if (all)
            all = std::unexpected(*bus.link_trouble());
    }
    for (auto& line : lines) // one that was lost meanwhile has stopped the others
        if (line->bus().link_trouble() == nullptr)
            line->bus().clear_stop();
    return all;
}

/// Carries out what all lines have in hand. The first failure, after all had their turn.
std::expected<void, Error> Core::exchange(std::string_view what)
{
    exchange_lines();
    for (auto& line : lines)
        for (std::size_t i = 0; i < line->results().size(); ++i)
            if (const auto& result = line->results()[i]; !result.good) {
                Error why = result.error;
                why.detail = fmt::format("{} of bus {}, {}: {}", line->owner(i).name(), line->bus().name(), what,
                                         to_sentence(result.error));
                why.message = {};
                why.id = -1;
                return std::unexpected(std::move(why));
            }
    return {};
}

template <class Plan>
std::expected<void, Error> Core::exchange_all(std::string_view what, Plan plan)
{
    for (auto& line : lines) {
        line->clear();
        for (Joint* joint : line->joints()) {
            const Planned requests = plan(*joint);
            if (!requests)
                return std::unexpected(joint->named(requests.error()));
            line->add(*joint, requests->all());
        }
    }
    return exchange(what);
}

std::expected<void, Error> Core::compare_models()
{
    if (auto done = exchange_all("it was asked what it is", [](Joint& joint) { return plan_identity(joint.device()); });
        !done)
        return done;
    for (auto& line : lines)
        for (std::size_t i = 0; i < line->results().size(); ++i) {
            const Joint& joint = line->owner(i);
            const auto fine = compare_identity(joint.name(), "the robot file", joint.device(), line->requests()[i],
                                               line->results()[i].replies[0]);
            if (!fine)
                return fine;
        }
    return {};
}

/// Hold, on, hold: twice, because a motor may take a command one frame late (field notes 2) and others confirm none.
std::expected<void, Error> Core::switch_all_on()
{
    const auto is_off = [](const Joint& joint) { return !joint.acknowledges_ && joint.is_limp(Mode::hold); };
    for (int turn = 0; turn < 2 || (turn < most_tries && std::ranges::any_of(joints, is_off)); ++turn) {
        const auto hold = [](Joint& joint) { return joint.driver_->plan({.mode = joint.holding(false)}, joint.raw_); };
        if (auto done = exchange_all("it was told to hold", hold); !done)
            return done;
        if (auto done = exchange_all("it was switched on", [](Joint& j) { return plan_switch_on(j.device()); }); !done)
            return done;
        if (auto done = exchange_all("it was told to hold", hold); !done)
            return done;
        // What was not heard is said again.
        const auto ask = [](Joint& joint) {
            return joint.acknowledges_ ? Planned{} : joint.driver_->plan_read(Depth::full);
        };
        if (auto done = exchange_all("its state", ask); !done)
            return done;
    }
    if (const auto joint = std::ranges::find_if(joints, is_off); joint != joints.end())
        return fail(Errc::bad_reply, fmt::format("{} was switched on and says that it is off", joint->name()));
    return {};
}

std::expected<void, Error> Core::check_no_stop() const
{
    if (stop_asked_.load())
        return fail(Errc::stopped, "a stop was asked for before the robot was enabled; enable it again to go on");
    return {};
}

std::expected<void, Error> Core::enable()
{
    const bool was_enabled = enabled;
    if (was_enabled)
        if (auto held = hold_all(); !held)
            return held;
    auto done = check_no_stop();
    if (!done && was_enabled)
        return stop_for({.code = Errc::stopped});
    enabled = false;
    if (done)
        done = look_before_enabling();
    const bool may_drive = was_enabled || done.has_value();
    if (done)
        done = take_hold();
    if (done)
        return done;
    if (may_drive) {
        enabled = true; // as far as that goes: what could not be told to hold may turn
        return stop_for(std::move(done.error()));
    }
    if (done.error().code == Errc::stopped) {
        let_a_stop_out();
        stop_asked_.store(false); // it is told
        tell_owed_stops();
    }
    for (auto& line : lines) { // nothing was driven
        if (!line->owes_stop())
            line->bus().set_stop({});
        tell_the_guardian(*line);
    }
    return done;
}

/// Whatever it is that takes time now, and may fail: nothing turns meanwhile.
std::expected<void, Error> Core::hold_all()
{
    if (auto fine = heed_the_guardian(); !fine)
        return fine;
    for (auto& line : lines)
        line->prepare_stop(clock->now()); // what is ready is of the last cycle, which may be long ago
    drive();
    for (auto& line : lines)
        if (line->busy())
            line->absorb(clock->now());
    for (Joint& joint : joints)
        if (joint.closed_ == nullptr && !lets_go(joint.command_) && joint.command_.mode != Mode::hold)
            joint.come_to_rest(joint.holding(false), clock->now());
    // Nobody is judged by what he said before: the program may have asked nothing for a while. Nor by one answer that
    // is missing, or not believed.
    const TimePoint begun = clock->now();
    const auto has_to_hear = [&](const Joint& joint) {
        return joint.closed_ == nullptr && (joint.answered_at_ < begun || joint.fresh_);
    };
    for (int i = 0; i < most_tries && (i == 0 || std::ranges::any_of(joints, has_to_hear)); ++i) {
        for (auto& line : lines)
            line->plan_cycle(clock->now());
        exchange_lines();
    }
    return look_at_all();
}

/// As often as it takes to believe answers without a checksum: what was read before a while is no place to hold.
std::expected<void, Error> Core::read_where_they_are()
{
    const TimePoint begun = clock->now();
    const auto is_old = [&](const Joint& joint) {
        const bool needs_place = joint.holds_a_position_ || joint.limits().position_low_rad ||
                                 joint.limits().position_high_rad; // a wheel may have turned too far to tell
        return !joint.raw_.position_rad || (needs_place && joint.raw_.position_rad.at() < begun);
    };
    for (int i = 0; i < times_to_believe || (i < times_to_believe + most_tries && std::ranges::any_of(joints, is_old));
         ++i) {
        const Depth depth = i == 0 ? Depth::full : Depth::motion;
        if (auto done = exchange_all("its state", [&](Joint& joint) { return joint.driver_->plan_read(depth); }); !done)
            return done;
    }
    if (const auto joint = std::ranges::find_if(joints, is_old); joint != joints.end())
        return fail(Errc::bad_reply, fmt::format("{} does not tell where it is, or not the same twice, so it cannot "
                                                 "be held to its limits",
                                                 joint->name()));
    return {};
}

/// Nothing is driven by that.
std::expected<void, Error> Core::look_before_enabling()
{
    for (auto& line : lines)
        line->forget_where_it_held(clock->now());
    if (auto back = bring_links_back(); !back)
        return back;
    if (auto fine = check_no_stop(); !fine)
        return fine; // its flags are cleared there
    for (auto& line : lines)
        line->clear();
    plan_owed_stops(true);
    exchange_lines();
    // A loss that ended no exchange is told by the first one.
    if (auto done = compare_models(); !done) {
        if (done.error().code != Errc::link_lost)
            return done;
        if (auto again = compare_models(); !again)
            return again;
    }
    if (auto done = exchange_all("its settings", [](Joint& joint) { return joint.driver_->plan_settings(); }); !done)
        return done;
    if (auto done = exchange_all("whether it starts afresh", [](Joint& j) { return j.driver_->plan_reset_check(); });
        !done)
        return done;
    if (auto done = read_where_they_are(); !done)
        return done;
    // From here on every joint is to hold, and a stop must not let go what a device held before.
    for (Joint& joint : joints) {
        joint.command_ = {.mode = Mode::hold};
        joint.is_told_ = false; // by the stop before
    }
    for (auto& line : lines)
        line->prepare_stop(clock->now());
    if (auto watched = hand_over(); !watched)
        return watched;
    return check_no_stop();
}

/// What may press on something lets go of it now: the first cycle may be long in coming. Where that fails, it is for
/// the stop to try again.
std::expected<void, Error> Core::let_go_of_all()
{
    for (Joint& joint : joints)
        joint.may_press_on_ = std::exchange(joint.must_relieve_, false) || joint.may_press_on_;
    const auto let_go = [](Joint& joint) {
        return joint.may_press_on_ ? plan_hold_anew(*joint.driver_, joint.raw_) : Planned{};
    };
    if (auto done = exchange_all("it was told to let go", let_go); !done)
        return done;
    for (Joint& joint : joints)
        joint.may_press_on_ = false;
    return {};
}

std::expected<void, Error> Core::take_hold()
{
    if (auto done = switch_all_on(); !done)
        return done;
    for (Joint& joint : joints)
        joint.owes_stop_ = false; // all of them hold, and are not to be told the policy by what reads them
    if (auto done = read(Depth::motion); !done)
        return done;
    const TimePoint now = clock->now();
    for (std::size_t i = 0; i < joints.size(); ++i) {
        Joint& joint = joints[i];
        joint.closed_ = nullptr;
        joint.closed_by_.reset();
        joint.must_set_up_ = joint.owes_stop_ = false;
        joint.begin(now);
        joint.full_at_ = joint.check_at_ = now + std::chrono::milliseconds{20} * static_cast<int>(i + 1);
    }
    if (auto done = let_go_of_all(); !done)
        return done;
    if (auto fine = check_no_stop(); !fine)
        return fine;
    fault.reset();
    enabled = true;
    for (auto& line : lines) {
        line->begin();
        line->prepare_stop(clock->now());
        tell_the_guardian(*line);
    }
    pause.begin(clock->now());
    return {};
}

} // namespace sinew::robot
