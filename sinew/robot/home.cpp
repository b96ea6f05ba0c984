#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/core.hpp"
#include "sinew/robot/stop_search.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <utility>

/// Finding and reaching position 0.
namespace sinew::robot {
namespace {

constexpr Duration look = std::chrono::milliseconds{10};
constexpr double arrived_rad = units::rad(0.5);
constexpr int most_lettings_go = 3; ///< each lets a load come down a little
/// One joint on its way against its stop.
struct Search {
    Joint* joint = nullptr;
    StopSearch search;
    StopSearch::Seen seen = StopSearch::Seen::way;
    std::uint64_t overruled = 0; ///< so often until it had found it
};

std::string was_stopped(const Joint& joint)
{
    return fmt::format("{} was stopped before it had found its stop{}", joint.name(),
                       joint.overruled_by() != nullptr ? ": " + to_sentence(*joint.overruled_by()) : std::string());
}

} // namespace

std::expected<void, Error> Joint::check_search() const
{
    if (auto open = check_open(); !open)
        return open;
    if (!state_.position_rad)
        return actuator::refuse(Errc::unsupported, id_of(device()),
                                fmt::format("{}: where it is has not been measured yet", name()));
    const Command turn{.mode = Mode::velocity, .velocity_rad_s = home_velocity_rad_s(file())};
    const auto able = actuator::check(mounting_.to_actuator(turn), driver_->capabilities(), id_of(device()));
    return able ? std::expected<void, Error>{} : std::unexpected(named(able.error()));
}

/// What `set` would refuse near a limit: its stop is beyond one. `StopSearch` bounds it instead.
void Joint::begin_search()
{
    guard_.watch_place(false);
    take({.mode = Mode::velocity, .velocity_rad_s = file().home.direction * home_velocity_rad_s(file())}, now());
}

/// It stands at its stop: that is where the robot file says.
void Joint::end_search()
{
    mounting_.zero_rad = mounting_.zero_rad_at(*raw_.position_rad, file().home.position_rad);
    state_ = mounting_.to_joint(raw_, driver_->capabilities().current_has_sign);
    can_ = mounting_.to_joint(driver_->capabilities());
    referenced_ = true;
    is_absolute_ = false; // in the turn that it counts now
    guard_.watch_place(true);
    begin(now());
}

/// Of what it holds against, where it did not acknowledge that. Whether it was due.
bool Joint::let_go_again()
{
    if (command_.mode != Mode::hold || !may_press_on_)
        return false;
    must_relieve_ = std::exchange(may_press_on_, false);
    fresh_ = true;
    has_heard_ = false;
    return true;
}

/// They must have heard it when this returns: nobody may drive after a routine that failed. A joint that takes no
/// command does what it was stopped with, and one that was let go stays free.
std::unexpected<Error> Core::hold_after(std::span<Joint* const> all, Error why)
{
    std::vector<Joint*> held;
    std::ranges::copy_if(all, std::back_inserter(held), [](const Joint* joint) {
        return joint->closed_ == nullptr && joint->command_.mode != Mode::release &&
               joint->command_.mode != Mode::brake;
    });
    for (Joint* joint : held) {
        if (joint->command_.mode != Mode::hold)
            joint->come_to_rest(joint->holding(false), clock->now());
        joint->stillness_.begin();
    }
    const auto is_at_rest = [](const Joint* joint) { return joint->stillness_.is_at_rest(); };
    // What ended the routine may have told others what they do now: that is planned, and has not gone out yet.
    const auto is_owed = [](const Joint& joint) { return joint.fresh_ && !joint.is_silent(); };
    const auto one_look = [&] {
        return !std::ranges::all_of(held, is_at_rest) || std::ranges::any_of(joints, is_owed);
    };
    auto ran = run(look, one_look, clock->now() + longest_rest);
    for (Joint* joint : all) {
        joint->guard_.watch_place(true);
        joint->guard_.begin(joint->state_, clock->now()); // from beyond its limits it may come back
    }
    if (!ran)
        return std::unexpected(std::move(ran.error()));
    for (const Joint* joint : held)
        if (!is_at_rest(joint))
            why.detail += fmt::format("; and {} was told to hold and was not seen to stand still", joint->name());
    return std::unexpected(std::move(why));
}

std::expected<void, Error> Core::find_stops(std::span<Joint* const> all, TimePoint until)
{
    using Seen = StopSearch::Seen;
    std::vector<Search> searches;
    for (Joint* joint : all)
        if (joint->file().home.to_stop) {
            if (auto able = joint->check_search(); !able)
                return able;
            searches.push_back({joint, {joint->file(), *joint->state_.position_rad, clock->now()}});
        }
    if (searches.empty())
        return {};
    for (auto& search : searches) // all or none: nobody ends a search that is left behind
        search.joint->begin_search();
    const auto lost_it_again = [](const Search& search) {
        return search.seen == Seen::stop && search.joint->overruled_ != search.overruled;
    };
    const auto one_look = [&] {
        for (auto& search : searches) {
            if (search.seen == Seen::stop) {
                if (lost_it_again(search))
                    return false;
                continue;
            }
            search.joint->renew();
            // Whoever was stopped by something else stands still as well, and not at his stop.
            if (search.joint->command_.mode != Mode::velocity)
                return false;
            search.seen =
                search.search.look(search.joint->state_.position_rad, search.joint->state_.current_a, clock->now());
            if (search.seen == Seen::stop && search.joint->is_limp(Mode::hold))
                search.seen = Seen::way; // whoever is off stands still as well
            if (search.seen == Seen::too_far)
                return false;
            if (search.seen == Seen::stop) {
                search.joint->end_search();
                search.overruled = search.joint->overruled_;
            }
        }
        return std::ranges::any_of(searches, [](const Search& one) { return one.seen == Seen::way; });
    };
    if (auto ran = run(look, one_look, until); !ran) {
        for (auto& search : searches)
            search.joint->guard_.watch_place(true);
        return ran;
    }
    std::vector<Joint*> failed;
    std::optional<Error> why;
    for (const auto& one : searches) {
        const auto& [joint, search, seen, overruled] = one;
        if (lost_it_again(one) && !why)
            why = joint->overruled_by_;
        if (seen == Seen::stop)
            continue;
        failed.push_back(joint);
        const bool was_ended = joint->command_.mode != Mode::velocity;
        if (!why)
            why = Error{.code = Errc::timeout,
                        .detail = was_ended               ? was_stopped(*joint)
                                  : seen == Seen::too_far ? search.says(joint->name())
                                                          : fmt::format("{} has found no stop in time; is `direction` "
                                                                        "of its home right?",
                                                                        joint->name())};
    }
    return why ? hold_after(failed, std::move(*why)) : std::expected<void, Error>{};
}

/// One joint that has its zero, and goes there, or holds at its stop because that is called 0: to be sent to where the
/// stop was pressed in would press on.
struct Core::Homeward {
    Joint* joint = nullptr;
    bool stays = false;
    std::uint64_t overruled = 0; ///< so often until it was told that
    int let_go = 0;              ///< so often once more

    bool is_near() const
    {
        const double near = std::max(arrived_rad, 2.0 * joint->can_.position_step_rad);
        return joint->state_.position_rad && std::abs(*joint->state_.position_rad) <= near;
    }
    bool is_at_rest() const { return joint->stillness_.is_at_rest() && !joint->is_limp(Mode::hold); }
    bool is_done() const { return is_at_rest() && is_near() && (!stays || joint->has_heard_); }
    bool has_come_away() const { return stays && is_at_rest() && joint->has_heard_ && !is_near(); }
    void look()
    {
        joint->renew();
        if (stays && let_go < most_lettings_go && joint->let_go_again())
            ++let_go;
    }
    bool was_ended() const
    {
        return joint->overruled_ != overruled || joint->closed_ != nullptr ||
               joint->command_.mode != (stays ? Mode::hold : Mode::position);
    }
    std::string why_not(Duration within) const
    {
        if (has_come_away())
            return fmt::format("{} was at its stop, and is {:.1f} deg away from it since it was let go of",
                               joint->name(), units::deg(std::abs(*joint->state_.position_rad)));
        if (stays)
            return fmt::format("{} is at its stop, and has not confirmed to hold there and to let go of it",
                               joint->name());
        return fmt::format("{} is at {:.2f} deg after {:.0f} s and not at 0; is something in its way?", joint->name(),
                           units::deg(joint->state_.position_rad.value_or(0.0)), seconds(within));
    }
};

std::expected<void, Error> Core::send_home(Homeward& one)
{
    Joint& joint = *one.joint;
    one.overruled = joint.overruled_;
    one.stays = joint.file().home.to_stop && one.is_near();
    if (one.stays)
        return {};
    if (!joint.referenced())
        joint.tell(Errc::unsupported,
                   fmt::format("{} cannot know where its position 0 is after power-on; it goes to where it counts "
                               "0. Give it a home with routine = \"stop\", or see to it yourself",
                               joint.name()));
    joint.stillness_.begin(); // it stood, perhaps, for it was let go
    return joint.set(
        {.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = home_velocity_rad_s(joint.file())});
}

std::expected<void, Error> Core::home(std::span<Joint* const> all, Duration within)
{
    const TimePoint until = clock->now() + within;
    if (!enabled)
        return fail(Errc::unsupported, "the robot is not enabled");
    if (auto found = find_stops(all, until); !found)
        return found;
    std::vector<Homeward> homeward;
    for (Joint* joint : all)
        if (auto sent = send_home(homeward.emplace_back(Homeward{.joint = joint})); !sent)
            return hold_after(all, std::move(sent.error()));
    bool arrived = false;
    const auto one_look = [&] {
        for (auto& one : homeward)
            one.look();
        arrived = std::ranges::all_of(homeward, &Homeward::is_done);
        return !arrived && std::ranges::none_of(
                               homeward, [](const Homeward& one) { return one.was_ended() || one.has_come_away(); });
    };
    if (auto ran = run(look, one_look, until); !ran)
        return ran;
    std::vector<Joint*> late;
    if (!arrived)
        for (const auto& one : homeward)
            if (!one.is_done())
                late.push_back(one.joint);
    if (const auto ended = std::ranges::find_if(homeward, &Homeward::was_ended); ended != homeward.end())
        return hold_after(late, ended->joint->overruled_by_.value_or(Error{.code = Errc::timeout}));
    if (late.empty())
        return {};
    const auto first = std::ranges::find(homeward, late.front(), &Homeward::joint);
    return hold_after(late, {.code = Errc::timeout, .detail = first->why_not(within)});
}

} // namespace sinew::robot
