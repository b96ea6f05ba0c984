#include "apps/cli/robot_session.hpp"

#include "apps/cli/device.hpp"
#include "apps/cli/interrupt.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/session.hpp"
#include "sinew/base/seconds.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// Of every bus that has one.
std::vector<std::string> links_of(const config::RobotFile& file, const robot::OpenOptions& options)
{
    std::vector<std::string> all;
    for (const config::Bus& bus : file.buses) {
        const auto given = options.links.find(bus.name);
        if (given != options.links.end())
            all.push_back(given->second);
        else if (options.simulated)
            all.push_back(fmt::format("sim:{}#{}", file.path, bus.name));
        else if (bus.link)
            all.push_back(bus.link->value);
    }
    return all;
}

bool is_simulated(const std::string& link)
{
    return sim::is_simulated(link);
}

/// The id beside the name of the joint says nothing more.
std::string_view said(const robot::Incident& incident)
{
    const std::string_view says = incident.says;
    const auto name = says.find(incident.joint + ": ");
    return says.starts_with("id ") && name != std::string_view::npos ? says.substr(name) : says;
}

} // namespace

std::vector<Option> with_robot_options(std::vector<Option> before)
{
    before.push_back({"--robot", "FILE", "the robot file (or SINEW_ROBOT)"});
    before.push_back(link_option);
    before.push_back({"--sim", "", "in a simulator within the command, in virtual time; does not ask"});
    before.push_back(yes_option);
    before.push_back(json_option);
    return before;
}

std::expected<config::RobotFile, Error> robot_file(const Words& words)
{
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, "which robot? Name its file with --robot FILE or in SINEW_ROBOT");
    if (is_recording(*path))
        return fail(Errc::bad_argument, fmt::format("{} is a recording, and what was recorded cannot be moved; name a "
                                                    "robot file",
                                                    *path));
    return config::read_robot_file(*path);
}

RobotSession::RobotSession() : links_(link::Links::system())
{
    sim::add(links_, worlds_);
    catch_interrupts();
}

std::expected<std::unique_ptr<RobotSession>, Error> RobotSession::open(const Words& words, config::RobotFile file)
{
    std::unique_ptr<RobotSession> out(new RobotSession);
    robot::OpenOptions options{.simulated = words.has("--sim")};
    auto links = given_links(words, file);
    if (!links)
        return std::unexpected(links.error());
    options.links = std::move(*links);
    const auto settings = bus_settings();
    if (!settings)
        return std::unexpected(settings.error());
    options.settings = *settings;
    const auto all = links_of(file, options);
    catch_suspension();
    if (!std::ranges::all_of(all, is_simulated)) {
        const auto& timeout = file.safety.command_timeout_s;
        auto guardian = start_guardian(timeout ? std::optional(from_seconds(*timeout)) : std::nullopt);
        if (!guardian)
            return std::unexpected(guardian.error());
        options.guardian = &out->guardian_.emplace(std::move(*guardian));
    }
    const auto clock = out->clock_for(all);
    if (!clock)
        return std::unexpected(clock.error());
    auto robot = robot::Robot::open(std::move(file), out->links_, **clock, options);
    if (!robot)
        return std::unexpected(robot.error());
    out->robot_.emplace(std::move(*robot));
    return out;
}

std::expected<link::Clock*, Error> RobotSession::clock_for(const std::vector<std::string>& links)
{
    link::Clock* clock = nullptr;
    for (const std::string& link : links) {
        const auto needed = sim::clock_for(link, real_, worlds_);
        if (!needed)
            return needed;
        if (clock != nullptr && *needed != clock)
            return fail(
                Errc::bad_argument,
                fmt::format("{} and {} have no common time; add clock=real to a simulated one", links.front(), link));
        clock = *needed;
    }
    return clock != nullptr ? clock : &real_;
}

void RobotSession::tell_incidents(const Error* told)
{
    const std::uint64_t dropped = robot_->incidents_dropped();
    if (told_ < dropped)
        fmt::print(stderr, "sinew: {} more that happened before are no longer known\n", dropped - told_);
    told_ = std::max(told_, dropped);
    for (const auto& incident : robot_->incidents().subspan(told_ - dropped)) {
        ++told_;
        if (told == nullptr || !incident.says.ends_with(to_sentence(*told)))
            fmt::print(stderr, "sinew: {}\n", said(incident));
    }
}

bool RobotSession::has_told(const Error& error) const
{
    const auto told = robot_->incidents().first(told_ - std::min(told_, robot_->incidents_dropped()));
    return std::ranges::any_of(told, [&](const auto& one) { return said(one) == to_sentence(error); });
}

} // namespace sinew::cli
