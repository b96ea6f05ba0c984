#include "apps/cli/turning.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/supervised.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration tick = std::chrono::milliseconds(20);
constexpr int ticks_per_line = 5;

struct Kind {
    std::string_view option;
    actuator::Mode mode;
    std::string_view unit;
    double shown = 1.0; ///< of the unit that is shown in one of SI
};

constexpr Kind kinds[] = {{"--velocity", actuator::Mode::velocity, "deg/s", 1.0 / units::rad_per_deg},
                          {"--current", actuator::Mode::current, "A"},
                          {"--torque", actuator::Mode::torque, "Nm"}};

const Kind& kind_of(actuator::Mode mode)
{
    return mode == actuator::Mode::velocity ? kinds[0] : mode == actuator::Mode::current ? kinds[1] : kinds[2];
}

std::expected<double, Error> value_from(const Kind& kind, std::string_view word)
{
    if (kind.mode == actuator::Mode::velocity) {
        const bool back = word.starts_with('-');
        const auto speed = speed_from(word.substr(back ? 1 : 0));
        return speed && back ? -*speed : speed;
    }
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    const auto unit = word.substr(static_cast<std::size_t>(end - word.data()));
    if (problem != std::errc{} || !std::isfinite(value) || unit != kind.unit)
        return fail(Errc::bad_argument,
                    fmt::format("{} takes a number with its unit, such as {}{}, not '{}'", kind.option,
                                kind.mode == actuator::Mode::current ? "0.5" : "0.2", kind.unit, word));
    return value;
}

actuator::Command command_for(const Turning& turning)
{
    actuator::Command out{.mode = turning.mode};
    auto& value = turning.mode == actuator::Mode::velocity  ? out.velocity_rad_s
                  : turning.mode == actuator::Mode::current ? out.current_a
                                                            : out.torque_nm;
    value = turning.value;
    return out;
}

/// With torque; without where holding is not possible, for nothing may go on turning.
std::expected<void, Error> end_with_torque(Session& session, Driven& driven)
{
    const auto rest = come_to_rest(session, driven, Otherwise::release);
    if (!rest)
        return std::unexpected(rest.error());
    if (const auto says = says_of(driven, *rest); !says.empty())
        fmt::print(stderr, "sinew: {}\n", says);
    return {};
}

/// Of a velocity that would have led much further than the device can tell.
std::expected<void, Error> check_moved(const Driven& driven, const Turning& turning, std::optional<double> from)
{
    constexpr double much_rad = units::rad(5.0);
    const auto here = position_of(driven);
    const double least = std::max(units::rad(0.5), 2.0 * driven.driver->capabilities().position_step_rad);
    if (turning.mode != actuator::Mode::velocity || !from || !here || std::abs(*here - *from) > least ||
        std::abs(turning.value) * seconds(turning.time) < much_rad)
        return {};
    const auto why = driven.driver->capabilities().velocity_is_duty
                         ? "such a speed may be less than its friction takes; try a higher one, or "
                           "a move to a position with --speed"
                         : "is something in its way, or is it switched off?";
    return fail(driven.driver->capabilities().velocity_is_duty ? Errc::unsupported : Errc::timeout,
                fmt::format("{} has not moved at {:g} deg/s: {}", driven.device.name, units::deg(turning.value), why));
}

} // namespace

std::expected<std::optional<Turning>, Error> turning_from(const Words& words)
{
    std::optional<Turning> out;
    for (const auto& kind : kinds) {
        const auto word = words.text(kind.option);
        if (!word)
            continue;
        if (out)
            return fail(Errc::bad_argument, "a joint is driven by one thing at a time: give --velocity, --current or "
                                            "--torque");
        const auto value = value_from(kind, *word);
        if (!value)
            return std::unexpected(value.error());
        out = Turning{.mode = kind.mode, .value = *value};
    }
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    if (!out) {
        if (*time)
            return fail(Errc::bad_argument,
                        "--for goes with --velocity, --current or --torque; a move to a position has "
                        "--in and --within");
        return out;
    }
    for (const auto* option : {"POSITION", "--speed", "--in", "--within"})
        if (words.has(option))
            return fail(Errc::bad_argument, fmt::format("{} belongs to a move to a position, and {} has none", option,
                                                        kind_of(out->mode).option));
    if (!*time)
        return fail(Errc::bad_argument, fmt::format("{} has no end of its own: add --for TIME, such as --for 2s",
                                                    kind_of(out->mode).option));
    out->time = **time;
    return out;
}

std::string describe(const Device& device, const Turning& turning)
{
    const auto& kind = kind_of(turning.mode);
    return fmt::format("{} will turn with {:g} {} for {:g} s", device.name, turning.value * kind.shown, kind.unit,
                       seconds(turning.time));
}

std::expected<void, Error> check_limits(const Device& device, const Turning& turning)
{
    const auto* joint = device.joint;
    if (joint == nullptr)
        return {};
    const auto beyond = [&](std::string_view what, std::optional<double> most, std::string_view key,
                            std::string_view unit) -> std::expected<void, Error> {
        if (!most || std::abs(turning.value) <= *most)
            return {};
        return fail(Errc::out_of_range, fmt::format("{} {:g} {} is beyond {} of {} in {}: {:g} {}", what, turning.value,
                                                    unit, key, device.name, device.file->path, *most, unit));
    };
    if (turning.mode == actuator::Mode::current)
        return beyond("current", joint->current_max_a ? joint->current_max_a : device.file->safety.current_max_a,
                      "current_max_a", "A");
    if (turning.mode == actuator::Mode::torque)
        return beyond("torque", joint->torque_max_nm, "torque_max_nm", "Nm");
    if (turning.mode != actuator::Mode::velocity || !joint->velocity_max_rad_s.has_value() ||
        std::abs(turning.value) <= *joint->velocity_max_rad_s)
        return {};
    return fail(Errc::out_of_range, fmt::format("speed {:g} deg/s is beyond velocity_max_deg_s of {} in {}: {:g} deg/s",
                                                units::deg(turning.value), device.name, device.file->path,
                                                units::deg(*joint->velocity_max_rad_s)));
}

Outcome turn_on(const Words& words, Session& session, Driven& driven, const Turning& turning)
{
    Supervised supervised(session, driven);
    const auto from = position_of(driven);
    const TimePoint begin = session.clock().now();
    auto done = supervised.send(command_for(turning));
    if (!done && !supervised.has_sent())
        return std::unexpected(done.error());
    for (int n = 1; done && !interrupted() && session.clock().now() - begin < turning.time; ++n) {
        wait_until(session, begin + n * tick);
        if (interrupted())
            break;
        done = supervised.look();
        if (n % ticks_per_line == 0 && !interrupted())
            show_state(words, driven, session.clock().now() - begin);
    }
    if (interrupted())
        return stop_here(session, driven, Otherwise::release);
    if (!done)
        return stopped_for(session, driven, done.error(), Otherwise::release);
    const auto ended = turning.mode == actuator::Mode::velocity ? end_with_torque(session, driven) : let_go(driven);
    if (!ended)
        return std::unexpected(ended.error());
    if (auto moved = check_moved(driven, turning, from); !moved && !interrupted())
        return std::unexpected(moved.error());
    return interrupted() ? exit_interrupted : exit_done; // it came while the motor was brought to rest
}

} // namespace sinew::cli
