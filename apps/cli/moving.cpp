#include "apps/cli/moving.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/identity.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration tick = std::chrono::milliseconds(20);        ///< between two looks
constexpr Duration step = std::chrono::milliseconds(100);       ///< between two that are shown
constexpr Duration standstill = std::chrono::milliseconds(800); ///< so long without progress is a stop

std::expected<void, Error> start(Driven& driven, const Goal& goal)
{
    auto command = move_to_position(driven, goal.position_rad, goal.speed_rad_s);
    if (goal.duration) {
        command.velocity_rad_s = goal.speed_rad_s;
        command.duration = goal.duration;
        const auto from = known_position_of(driven);
        if (!from)
            return std::unexpected(from.error());
        const double mean_speed = std::abs(goal.position_rad - *from) / seconds(*goal.duration);
        if (auto fine = check_limits(driven.device, goal.position_rad, mean_speed); !fine)
            return fine;
    }
    const auto requests = plan(driven, command);
    return requests ? carry_out(driven, *requests) : std::unexpected(requests.error());
}

std::unexpected<Error> give_up(Session& session, Driven& driven, const Goal& goal, Error why)
{
    return goal.holds_if_it_fails ? held_after(session, driven, std::move(why)) : std::unexpected(std::move(why));
}

/// Looks until it has arrived, stands still or the time is over.
Outcome follow(const Words& words, Session& session, Driven& driven, const Goal& goal, double tolerance_rad,
               TimePoint started)
{
    const TimePoint begin = session.clock().now();
    // A move that takes its time may begin too gently to be seen.
    TimePoint progressed = begin + goal.duration.value_or(Duration{});
    std::optional<double> last = position_of(driven);
    TimePoint shown = begin;
    for (TimePoint look = begin + tick;; look = std::max(look + tick, session.clock().now())) {
        wait_until(session, look);
        auto read = interrupted() ? std::expected<void, Error>{} : read_state(driven, actuator::Depth::motion);
        if (interrupted())
            return stop_here(session, driven);
        if (!read)
            return give_up(session, driven, goal, read.error());
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
        if (here && now - progressed > standstill)
            return give_up(
                session, driven, goal,
                {.code = Errc::unsupported,
                 .detail = fmt::format("{} stands still at {}, short of {:.2f} deg; is something in its way, or "
                                       "is it switched off?",
                                       driven.device.name, place_of(driven), units::deg(goal.position_rad))});
        if (now - begin > goal.limit)
            return give_up(
                session, driven, goal,
                {.code = Errc::timeout,
                 .detail = fmt::format("{} is at {} after {:g} s and still moves; --within gives it more time",
                                       driven.device.name, place_of(driven), seconds(goal.limit))});
    }
}

/// Leads it there in small steps, for a device without a speed of its own. Nothing: it is at the last step.
std::expected<std::optional<int>, Error> lead(const Words& words, Session& session, Driven& driven, const Goal& goal)
{
    const TimePoint begin = session.clock().now();
    const auto from = known_position_of(driven);
    if (!from)
        return std::unexpected(from.error());
    const double length = goal.position_rad - *from;
    TimePoint shown = begin;
    for (TimePoint next = begin + tick;; next += tick) {
        wait_until(session, next);
        const double travelled = *goal.speed_rad_s * seconds(next - begin);
        const bool is_last = travelled >= std::abs(length);
        const double at = is_last ? goal.position_rad : *from + std::copysign(travelled, length);
        const auto requests = plan(driven, {.mode = actuator::Mode::position, .position_rad = at});
        auto sent = !requests       ? std::unexpected(requests.error())
                    : interrupted() ? std::expected<void, Error>{}
                                    : carry_out(driven, *requests);
        if (sent && !interrupted() && next - shown >= step) {
            sent = read_state(driven, actuator::Depth::motion);
            if (sent && !interrupted())
                show_state(words, driven, next - begin);
            shown = next;
        }
        if (interrupted()) {
            const auto stopped = stop_here(session, driven);
            return stopped ? std::expected<std::optional<int>, Error>(*stopped) : std::unexpected(stopped.error());
        }
        if (!sent)
            return give_up(session, driven, goal, sent.error());
        // What does not follow must not be led on: it would leap when it comes free.
        if (const auto here = position_of(driven);
            here && std::abs(*here - at) > units::rad(10.0) + *goal.speed_rad_s) {
            return give_up(session, driven, goal,
                           {.code = Errc::unsupported,
                            .detail = fmt::format("{} stays behind at {}; is something in its way?", driven.device.name,
                                                  place_of(driven))});
        }
        if (is_last)
            return std::nullopt;
    }
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
    if (goal.in_steps && goal.speed_rad_s && !driven.driver->capabilities().velocity_limit) {
        const auto ended = lead(words, session, driven, goal);
        if (!ended)
            return std::unexpected(ended.error());
        return *ended ? Outcome(**ended) : follow(words, session, driven, goal, tolerance_rad, started);
    }
    if (auto sent = start(driven, goal); !sent) {
        // The command may be out although nobody acknowledged it.
        const auto code = sent.error().code;
        if (code == Errc::stopped)
            return stop_here(session, driven);
        return may_pass(code) ? held_after(session, driven, sent.error())
                              : give_up(session, driven, goal, sent.error());
    }
    return follow(words, session, driven, goal, tolerance_rad, started);
}

} // namespace sinew::cli
