#include "apps/cli/joint.hpp"

#include "sinew/base/units.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace sinew::cli {
namespace {

struct Unit {
    std::string_view name;
    double si = 1.0;
};

constexpr Unit angles[] = {
    {"deg", units::rad_per_deg}, {"rad", 1.0}, {"turns", 2.0 * std::numbers::pi}, {"turn", 2.0 * std::numbers::pi}};
constexpr Unit speeds[] = {
    {"deg/s", units::rad_per_deg}, {"dps", units::rad_per_deg}, {"rad/s", 1.0}, {"rpm", units::rad_s_per_rpm}};

std::optional<double> measure(std::string_view word, std::span<const Unit> units)
{
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    const auto rest = word.substr(static_cast<std::size_t>(end - word.data()));
    for (const auto& unit : units)
        if (problem == std::errc{} && rest == unit.name && std::isfinite(value))
            return value * unit.si;
    return std::nullopt;
}

std::string faults_of(const actuator::State& state)
{
    if (!state.faults)
        return {};
    std::string out;
    for (unsigned bit = 1; bit <= static_cast<unsigned>(actuator::Fault::unexplained); bit <<= 1U) {
        const auto fault = static_cast<actuator::Fault>(bit);
        if (!state.faults->has(fault))
            continue;
        out += out.empty() ? "" : ", ";
        if (fault == actuator::Fault::over_temperature)
            out += "hot"; // a narrow column
        else if (fault == actuator::Fault::unexplained)
            out += fmt::format("unexplained 0x{:X}", state.raw_faults);
        else
            out += to_word(fault);
    }
    return out.empty() ? "none" : out;
}

std::string cell(const std::optional<double>& value, std::string_view format_unit, int decimals)
{
    // Small values that round to zero have no sign worth showing.
    const double least = 0.5 * std::pow(10.0, -decimals);
    return value ? fmt::format("{:.{}f} {}", std::abs(*value) < least ? 0.0 : *value, decimals, format_unit)
                 : std::string{};
}

std::optional<double> joint_velocity(const Driven& d)
{
    return d.state.velocity_rad_s ? std::optional(to_joint_velocity(d.device.joint, *d.state.velocity_rad_s))
                                  : std::nullopt;
}

std::optional<double> in_deg(std::optional<double> rad)
{
    return rad ? std::optional(units::deg(*rad)) : std::nullopt;
}

std::unexpected<Error> beyond(const Device& device, std::string_view what, double value, std::string_view limit_name,
                              double limit, std::string_view unit)
{
    return fail(Errc::out_of_range,
                fmt::format("{} {:g} {} is beyond {} of {} in {}: {:g} {}", what, units::deg(value), unit, limit_name,
                            device.name, device.file->path, units::deg(limit), unit));
}

} // namespace

robot::Mounting mounting_of(const config::Joint* joint)
{
    return joint != nullptr ? robot::Mounting::of(*joint) : robot::Mounting{};
}

double to_joint_position(const config::Joint* joint, double actuator_rad)
{
    return mounting_of(joint).to_joint(actuator_rad);
}

double to_joint_velocity(const config::Joint* joint, double actuator_rad_s)
{
    return mounting_of(joint).to_joint_velocity(actuator_rad_s);
}

double to_actuator_position(const config::Joint* joint, double joint_rad)
{
    return mounting_of(joint).to_actuator(joint_rad);
}

std::optional<double> position_of(const Driven& driven)
{
    const auto& at = driven.state.position_rad;
    return at ? std::optional(to_joint_position(driven.device.joint, *at)) : std::nullopt;
}

std::string place_of(const Driven& driven)
{
    const auto here = position_of(driven);
    return here ? fmt::format("{:.2f} deg", units::deg(*here)) : "a place that it did not say";
}

std::expected<double, Error> known_position_of(const Driven& driven)
{
    if (const auto here = position_of(driven))
        return *here;
    return fail(Errc::bad_reply, fmt::format("{} does not say where it is", driven.device.name));
}

std::expected<double, Error> start_of(const Driven& driven)
{
    // A sensor reads a little further than what may be commanded: 32 units of a SAM.
    constexpr double further_rad = units::rad(3.0);
    const auto here = known_position_of(driven);
    const auto& can = driven.driver->capabilities();
    const auto& at = driven.state.position_rad;
    if (at && ((can.position_low_rad && *at < *can.position_low_rad - further_rad) ||
               (can.position_high_rad && *at > *can.position_high_rad + further_rad)))
        return fail(
            Errc::out_of_range,
            fmt::format("{} says that it is at {}, which is further than a {} reaches; is its model right? Else "
                        "turn it back by hand, after sinew stop",
                        driven.device.name, place_of(driven), driven.device.model()));
    return here;
}

std::expected<wire::Requests, Error> plan(Driven& driven, const actuator::Command& command)
{
    return driven.driver->plan(mounting_of(driven.device.joint).to_actuator(command), driven.state);
}

actuator::Command move_to_position(const Driven& driven, double position_rad, std::optional<double> speed_rad_s)
{
    const auto* joint = driven.device.joint;
    if (!speed_rad_s && joint != nullptr && driven.driver->capabilities().velocity_limit)
        speed_rad_s = joint->velocity_max_rad_s;
    return {.mode = actuator::Mode::position, .position_rad = position_rad, .velocity_rad_s = speed_rad_s};
}

std::expected<void, Error> check_limits(const Device& device, double position_rad, std::optional<double> speed_rad_s)
{
    const auto* joint = device.joint;
    if (joint == nullptr)
        return {};
    if (joint->position_min_rad && position_rad < *joint->position_min_rad)
        return beyond(device, "position", position_rad, "position_min_deg", *joint->position_min_rad, "deg");
    if (joint->position_max_rad && position_rad > *joint->position_max_rad)
        return beyond(device, "position", position_rad, "position_max_deg", *joint->position_max_rad, "deg");
    if (joint->velocity_max_rad_s && speed_rad_s && *speed_rad_s > *joint->velocity_max_rad_s)
        return beyond(device, "speed", *speed_rad_s, "velocity_max_deg_s", *joint->velocity_max_rad_s, "deg/s");
    return {};
}

Json state_json(const Driven& driven, Duration since_start)
{
    const auto& s = driven.state;
    return Json::object({{"time_s", seconds(since_start)},
                         {"name", driven.device.name},
                         {"position_rad", position_of(driven)},
                         {"velocity_rad_s", joint_velocity(driven)},
                         {"current_a", s.current_a.optional()},
                         {"voltage_v", s.voltage_v.optional()},
                         {"temperature_c", s.temperature_c.optional()},
                         {"faults", s.faults ? Json(faults_of(s)) : Json()}});
}

std::vector<std::string> state_cells(const Driven& driven)
{
    const auto& s = driven.state;
    return {cell(in_deg(position_of(driven)), "deg", 2),
            cell(in_deg(joint_velocity(driven)), "deg/s", 1),
            cell(s.current_a, "A", 2),
            cell(s.voltage_v, "V", 1),
            cell(s.temperature_c, "°C", 0),
            faults_of(s)};
}

std::expected<double, Error> angle_from(std::string_view word)
{
    if (const auto value = measure(word, angles))
        return *value;
    return fail(Errc::bad_argument,
                fmt::format("'{}' is no angle; write one with its unit, such as 90deg, 1.57rad or 0.25turn", word));
}

std::expected<double, Error> speed_from(std::string_view word)
{
    if (const auto value = measure(word, speeds); value && *value > 0.0)
        return *value;
    return fail(
        Errc::bad_argument,
        fmt::format("'{}' is no speed; write one above zero with its unit, such as 30deg/s, 1rad/s or 10rpm", word));
}

} // namespace sinew::cli
