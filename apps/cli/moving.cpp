#include "apps/cli/moving.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/supervised.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/identity.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration tick = std::chrono::milliseconds(20);  ///< between two looks
constexpr Duration step = std::chrono::milliseconds(100); ///< between two that are shown

/// Looks until it has arrived, stands still or the time is over.
Outcome follow(const Words& words, Session& session, Driven& driven, Supervised& supervised, const Goal& goal,
               double tolerance_rad, TimePoint started)
{
    const auto give_up = [&](std::string why) {
        return held_after(session, driven, Error{.code = Errc::timeout, .detail = std::move(why)});
    };
    const TimePoint begin = session.clock().now();
    // A move that takes its time may begin too gently to be seen.
    TimePoint progressed = begin + goal.duration.value_or(Duration{});
    std::optional<double> last = position_of(driven);
    TimePoint shown = begin;
    for (TimePoint look = begin + tick;; look = std::max(look + tick, session.clock().now())) {
        wait_until(session, look);
        const auto seen = interrupted() ? std::expected<void, Error>{} : supervised.look();
        if (interrupted())
            return stop_here(session, driven);
        if (!seen)
            return stopped_for(session, driven, seen.error());
        const TimePoint now = session.clock().now();
        const auto here = position_of(driven);
        // More are taken than shown: where a guardian would hold must not be old.
        const bool arrived = here && std::abs(*here - goal.position_rad) <= tolerance_rad;
        if (look - shown >= step) {
            show_state(words, driven, now - started);
            shown = look;
        } else {
            continue;
        }
        if (arrived)
            return exit_done;
        if (here && (!last || std::abs(*here - *last) > tolerance_rad / 10.0)) {
            progressed = std::max(progressed, now);
            last = here;
        }
        if (here && now - progressed > robot::Supervisor::patience &&
            std::abs(*here - goal.position_rad) <= robot::giving_way_rad)
            return fail(
                Errc::timeout,
                fmt::format("{} stands still at {}, short of {:.2f} deg, and stays on its way there; does it give "
                            "way to a load?",
                            driven.device.name, place_of(driven), units::deg(goal.position_rad)));
        if (here && now - progressed > robot::Supervisor::patience)
            return give_up(fmt::format("{} stands still at {}, short of {:.2f} deg; is something in "
                                       "its way, or is it switched off?",
                                       driven.device.name, place_of(driven), units::deg(goal.position_rad)));
        if (now - begin > goal.limit)
            return give_up(fmt::format("{} is at {} after {:g} s and still moves; --within gives it more time",
                                       driven.device.name, place_of(driven), seconds(goal.limit)));
    }
}

/// Leads it there in small steps, for a device without a speed of its own. Nothing: it is at the last step. It waits
/// for one that does not follow, until that counts as blocked.
std::expected<void, Error> lead(const Words& words, Session& session, Driven& driven, Supervised& supervised,
                                const Goal& goal, double speed_rad_s)
{
    const TimePoint begin = session.clock().now();
    if (const auto from = known_position_of(driven); !from)
        return std::unexpected(from.error());
    TimePoint last = begin, shown = begin;
    for (TimePoint next = begin + tick; supervised.reference_rad() != goal.position_rad;
         next = std::max(next + tick, session.clock().now())) {
        wait_until(session, next);
        if (interrupted())
            return {};
        // The loop may have been late; what it was late by is not gone at once.
        const TimePoint now = session.clock().now();
        const double most = speed_rad_s * seconds(std::min(now - last, robot::Supervisor::longest_gap));
        last = now;
        const double way = goal.position_rad - *supervised.reference_rad();
        const double wanted =
            std::abs(way) <= most ? goal.position_rad : goal.position_rad - way + std::copysign(most, way);
        auto done =
            supervised.send({.mode = actuator::Mode::position, .position_rad = supervised.nearest_step_rad(wanted)});
        if (done && !interrupted())
            done = supervised.look();
        if (!done || interrupted())
            return done;
        if (now - shown >= step) {
            show_state(words, driven, now - begin);
            shown = now;
        }
    }
    return {};
}

/// The speed at which a device is led that knows none for moves; nothing: it is sent there.
std::optional<double> leading_speed(const Driven& driven, const Goal& goal)
{
    if (goal.duration || driven.driver->capabilities().velocity_limit)
        return std::nullopt;
    const auto* joint = driven.device.joint;
    return goal.speed_rad_s || joint == nullptr ? goal.speed_rad_s : joint->velocity_max_rad_s;
}

std::expected<void, Error> start(const Words& words, Session& session, Driven& driven, Supervised& supervised,
                                 const Goal& goal)
{
    if (const auto speed = leading_speed(driven, goal))
        return lead(words, session, driven, supervised, goal, *speed);
    auto command = move_to_position(driven, goal.position_rad, goal.speed_rad_s);
    if (goal.duration) {
        command.velocity_rad_s.reset();
        command.duration = goal.duration;
    }
    return supervised.send(command);
}

/// With another model every scale is another one, and so is where it goes.
std::expected<void, Error> check_identity(const Driven& driven)
{
    const auto& device = driven.device;
    const auto asked = robot::plan_identity(*device.spec);
    if (!asked)
        return std::unexpected(asked.error());
    std::array<bus::Result, wire::Requests::capacity> results;
    const auto used = std::span(results).first(asked->all().size());
    if (auto sent = driven.bus->exchange(asked->all(), used); !sent)
        return sent;
    const auto source = device.joint != nullptr ? "the robot file" : "the command line";
    for (std::size_t i = 0; i < used.size(); ++i) {
        const auto reply = used[i].reply();
        if (!reply)
            return std::unexpected(reply.error());
        if (auto fine = robot::compare_identity(device.name, source, *device.spec, asked->all()[i], *reply); !fine)
            return fine;
    }
    return {};
}

} // namespace

void show_state(const Words& words, const Driven& driven, Duration since_start)
{
    if (words.json()) {
        print_line(state_json(driven, since_start));
        return;
    }
    const auto cells = state_cells(driven);
    std::string line = fmt::format("{:6.2f} s", seconds(since_start));
    for (const auto& cell : cells)
        if (!cell.empty() && cell != "none")
            line += fmt::format("  {:>12}", cell);
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

std::expected<Driven, Error> drive_and_read(Session& session, Device device)
{
    if (auto guarded = session.guard(device); !guarded)
        return std::unexpected(guarded.error());
    auto driven = drive(session, std::move(device));
    if (!driven)
        return driven;
    if (session.guardian() != nullptr)
        driven->guard = std::make_unique<MotionGuard>(*session.guardian(), driven->device);
    if (auto same = check_identity(*driven); !same)
        return std::unexpected(same.error());
    if (auto set = set_up(*driven); !set)
        return std::unexpected(set.error());
    if (auto read = read_state(*driven, actuator::Depth::full); !read)
        return std::unexpected(read.error());
    return driven;
}

Outcome move_to(const Words& words, Session& session, Driven& driven, const Goal& goal)
{
    // Where a device stops within is not documented; half a degree is what the coarsest of them can tell.
    const double finest = 2.0 * driven.driver->capabilities().position_step_rad;
    const double tolerance_rad = std::max(units::rad(0.5), finest);
    const TimePoint started = session.clock().now();
    if (const auto from = start_of(driven); !from)
        return std::unexpected(from.error());
    Supervised supervised(session, driven);
    const auto sent = start(words, session, driven, supervised, goal);
    if (!sent && !supervised.has_sent())
        return std::unexpected(sent.error());
    if (interrupted())
        return stop_here(session, driven);
    // The command may be out although nobody acknowledged it.
    if (!sent)
        return stopped_for(session, driven, sent.error());
    return follow(words, session, driven, supervised, goal, tolerance_rad, started);
}

} // namespace sinew::cli
