#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/core.hpp"
#include "sinew/robot/stop_search.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

/// Finding and reaching position 0.
namespace sinew::robot {
namespace {

constexpr Duration look = std::chrono::milliseconds{10};
constexpr double arrived_rad = units::rad(0.5);

/// One joint on its way against its stop.
struct Search {
    Joint* joint = nullptr;
    StopSearch search;
    bool found = false;
};

} // namespace

void Joint::begin_search()
{
    guard_.watch_place(false);
    const auto& home = file().home;
    take({.mode = Mode::velocity, .velocity_rad_s = home.direction * home.velocity_rad_s}, now());
}

/// It stands at its stop: that is where the robot file says.
void Joint::end_search(bool found)
{
    if (found && raw_.position_rad) {
        mounting_.zero_rad = mounting_.zero_rad_at(*raw_.position_rad, file().home.position_rad);
        state_ = mounting_.to_joint(raw_, driver_->capabilities().current_has_sign);
        can_ = mounting_.to_joint(driver_->capabilities());
        referenced_ = true;
    }
    guard_.watch_place(true);
    begin(now());
}

std::expected<void, Error> Core::find_stops(std::span<Joint* const> all, TimePoint until)
{
    std::vector<Search> searches;
    for (Joint* joint : all)
        if (joint->file().home.to_stop)
            searches.push_back({joint, {joint->state_.position_rad.value_or(0.0), clock->now()}});
    for (auto& search : searches) {
        const auto able =
            actuator::check(search.joint->mounting_.to_actuator(Command{
                                .mode = Mode::velocity, .velocity_rad_s = search.joint->file().home.velocity_rad_s}),
                            search.joint->driver_->capabilities(), id_of(search.joint->device()));
        if (!able)
            return std::unexpected(search.joint->named(able.error()));
    }
    for (auto& search : searches) // all or none: nobody ends a search that is left behind
        search.joint->begin_search();
    const auto one_look = [&] {
        for (auto& search : searches) {
            if (search.found)
                continue;
            search.joint->renew();
            // Whoever was stopped by something else stands still as well, and not at his stop.
            if (search.joint->command_.mode != Mode::velocity)
                return false;
            search.found =
                search.search.found(search.joint->state_.position_rad, search.joint->file().home.velocity_rad_s);
            if (search.found)
                search.joint->end_search(true);
        }
        return std::ranges::any_of(searches, [](const Search& one) { return !one.found; });
    };
    auto ran = searches.empty() ? std::expected<void, Error>{} : run(look, one_look, until);
    for (auto& search : searches)
        if (!search.found) {
            search.joint->guard_.watch_place(true);
            if (!ran)
                continue;
            const bool was_ended = search.joint->command_.mode != Mode::velocity;
            search.joint->end_search(false);
            ran =
                fail(Errc::timeout,
                     was_ended ? fmt::format("{} was stopped before it had found its stop{}{}", search.joint->name(),
                                             search.joint->trouble() != nullptr ? ": " : "",
                                             search.joint->trouble() != nullptr ? to_sentence(*search.joint->trouble())
                                                                                : std::string())
                               : fmt::format("{} has found no stop; is `direction` of its home right?",
                                             search.joint->name()));
        }
    return ran;
}

std::expected<void, Error> Core::home(std::span<Joint* const> all, Duration within)
{
    const TimePoint until = clock->now() + within;
    if (!enabled)
        return fail(Errc::unsupported, "the robot is not enabled");
    if (auto found = find_stops(all, until); !found)
        return found;
    for (Joint* joint : all) {
        if (!joint->referenced())
            joint->tell(Errc::unsupported,
                        fmt::format("{} cannot know where its position 0 is after power-on; it goes to where it counts "
                                    "0. Give it a home with routine = \"stop\", or see to it yourself",
                                    joint->name()));
        const double velocity =
            std::min(joint->file().home.velocity_rad_s,
                     joint->limits().velocity_max_rad_s.value_or(joint->file().home.velocity_rad_s));
        if (auto set = joint->set({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = velocity}); !set) {
            for (Joint* other : all)
                other->hold_here(clock->now());
            return set;
        }
    }
    const auto is_there = [](Joint* joint) {
        const double near = std::max(arrived_rad, 2.0 * joint->can_.position_step_rad);
        return joint->state_.position_rad && std::abs(*joint->state_.position_rad) <= near &&
               std::abs(joint->guard_.velocity_rad_s()) < arrived_rad;
    };
    bool arrived = false;
    const auto one_look = [&] {
        for (Joint* joint : all)
            joint->renew();
        arrived = std::ranges::all_of(all, is_there);
        return !arrived;
    };
    if (auto ran = run(look, one_look, until); !ran)
        return ran;
    std::expected<void, Error> out;
    for (Joint* joint : all)
        if (!arrived && !is_there(joint)) {
            joint->hold_here(clock->now());
            if (out)
                out = fail(Errc::timeout,
                           fmt::format("{} is at {:.2f} deg after {:.0f} s and not at 0; is something in its way?",
                                       joint->name(), units::deg(joint->state_.position_rad.value_or(0.0)),
                                       seconds(within)));
        }
    return out;
}

} // namespace sinew::robot
