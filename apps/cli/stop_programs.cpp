#include "apps/cli/stop_programs.hpp"

#include "sinew/link/uri.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// Whether two links lead to the same port, whatever they say of it.
bool is_same_port(const std::string& one, const std::string& other)
{
    const auto a = link::parse_uri(one), b = link::parse_uri(other);
    std::error_code none;
    return a && b && (a->target == b->target || std::filesystem::equivalent(a->target, b->target, none));
}

/// A program that moves one device has its id behind the # of its link.
bool answers_for(const robot::StoppedProgram& told, const std::string& link, int id)
{
    return std::ranges::all_of(told.buses, [&](const auto& one) {
        const auto uri = link::parse_uri(one.link);
        return !is_same_port(one.link, link) || !uri || uri->fragment.empty() || uri->fragment == std::to_string(id);
    });
}

bool holds(const robot::Guarded& program, const std::string& link)
{
    return std::ranges::any_of(program.links, [&](const auto& held) { return is_same_port(held, link); });
}

Done done(const std::string& name, int pid, const robot::StoppedProgram& told, const std::string& link)
{
    using enum robot::StoppedBus::Outcome;
    const auto who = fmt::format("{}the program with process id {}", told.by_guardian ? "the guardian of " : "", pid);
    const auto bus = std::ranges::find_if(told.buses, [&](const auto& one) { return is_same_port(one.link, link); });
    if (bus == told.buses.end())
        return {name, fail(Errc::timeout, fmt::format("{} says nothing of {}", who, link)), true};
    if (bus->outcome == failed)
        return {name,
                fail(bus->says.contains("link is lost") ? Errc::link_lost : Errc::timeout,
                     fmt::format("{} was asked to stop {}: {}", who, link, bus->says)),
                true};
    if (bus->outcome == confirmed)
        return {name, Told{fmt::format("{} stopped its motors", who), true}};
    if (told.by_guardian)
        return {name,
                fail(Errc::timeout, fmt::format("{} told {} to stop, and no device could be asked whether it did; "
                                                "end that program and stop again",
                                                who, link)),
                true};
    return {name, Told{fmt::format("{} told its motors to stop (not acknowledged)", who), false}};
}

} // namespace

bool Programs::hold(const std::string& link) const
{
    return std::ranges::any_of(all_, [&](const auto& program) { return holds(program, link); });
}

std::optional<Done> Programs::stop_holder(const std::string& name, const std::string& link, int id)
{
    for (const auto& program : all_) {
        if (!holds(program, link))
            continue;
        if (!told_.contains(program.pid))
            told_.emplace(program.pid, robot::stop_program(program.pid));
        if (const auto& told = told_.at(program.pid); told && answers_for(*told, link, id))
            return done(name, program.pid, *told, link);
    }
    return std::nullopt;
}

void wait_for_port(Session& session, const Programs& programs, const std::string& link)
{
    constexpr Duration longest = std::chrono::seconds(5);
    constexpr Duration between = std::chrono::milliseconds(20);
    if (!programs.any_was_told())
        return;
    const TimePoint end = session.clock().now() + longest;
    for (TimePoint now = session.clock().now(); now < end; now = session.clock().now()) {
        const auto opened = session.open(link);
        if (opened || opened.error().code != Errc::link_busy)
            return;
        session.clock().wait({}, now + between);
    }
}

} // namespace sinew::cli
