#include "apps/cli/home_stop.hpp"

#include "apps/cli/supervised.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/mounting.hpp"
#include "sinew/robot/stop_search.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration tick = std::chrono::milliseconds(20);
constexpr int ticks_per_line = 5;

/// From now on the joint counts from here: where it stands is where the robot file says that its stop is.
void count_from_stop(Device& device, double actuator_rad)
{
    auto file = std::make_shared<config::RobotFile>(*device.file);
    auto& joint = file->joints[static_cast<std::size_t>(device.joint - device.file->joints.data())];
    joint.zero_rad = robot::Mounting::of(joint).zero_rad_at(actuator_rad, joint.home.position_rad);
    device.joint = &joint;
    device.file = std::move(file);
}

actuator::Measured<double> place(const Driven& driven)
{
    const auto& at = driven.state.position_rad;
    return at ? actuator::Measured<double>{to_joint_position(driven.device.joint, *at), at.at()}
              : actuator::Measured<double>{};
}

std::expected<std::optional<int>, Error> ended_by(const Outcome& outcome)
{
    return outcome ? std::expected<std::optional<int>, Error>(*outcome) : std::unexpected(outcome.error());
}

} // namespace

std::expected<std::optional<int>, Error> find_stop(const Words& words, Session& session, Driven& driven)
{
    using Seen = robot::StopSearch::Seen;
    const auto& joint = *driven.device.joint;
    const auto from = known_position_of(driven);
    if (!from)
        return std::unexpected(from.error());
    const TimePoint begin = session.clock().now();
    robot::StopSearch search(joint, *from, begin);
    Supervised supervised(session, driven);
    auto done = supervised.search(joint.home.direction * robot::home_velocity_rad_s(joint));
    if (!done && !supervised.has_sent())
        return std::unexpected(done.error());
    for (int n = 1; done && !interrupted(); ++n) {
        wait_until(session, begin + n * tick);
        if (interrupted())
            break;
        done = supervised.look();
        const Seen seen = done ? search.look(place(driven), driven.state.current_a, session.clock().now()) : Seen::way;
        if (!done || seen == Seen::stop)
            break;
        if (n % ticks_per_line == 0)
            show_state(words, driven, session.clock().now() - begin);
        if (seen == Seen::too_far)
            done = fail(Errc::timeout, search.says(driven.device.name));
    }
    if (interrupted())
        return ended_by(stop_here(session, driven, Otherwise::release));
    if (!done)
        return ended_by(stopped_for(session, driven, done.error(), Otherwise::release));
    const double stop_rad = *driven.state.position_rad; // else it would not be found
    if (read_state(driven, actuator::Depth::full) && driven.state.says_off())
        return ended_by(stopped_for(
            session, driven,
            {.code = Errc::unsupported,
             .detail = fmt::format("{} stands still because it is off, and not at its stop", driven.device.name)},
            Otherwise::release));
    const auto rest = come_to_rest(session, driven, Otherwise::release);
    if (!rest)
        return std::unexpected(rest.error());
    if (const auto says = says_of(driven, *rest); !says.empty())
        fmt::print(stderr, "sinew: {}\n", says);
    count_from_stop(driven.device, stop_rad);
    if (!words.json())
        fmt::print("{} has found its stop: {:.2f} deg by the robot file; zero_deg = {:.2f} until it is switched off\n",
                   driven.device.name, units::deg(driven.device.joint->home.position_rad),
                   units::deg(driven.device.joint->zero_rad));
    return std::nullopt;
}

} // namespace sinew::cli
