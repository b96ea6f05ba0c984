#include "sinew/family/rmd/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace sinew::rmd {
namespace {

constexpr double angle_lsb_deg = 0.01; // A3 … A8 (L860, L901)
constexpr double speed_lsb_dps = 0.01; // A2 (L813)
/// lk-2.36 sends a current limit with the speed: full scale leaves it to the motor. Other lines have no such field.
constexpr std::int64_t no_current_limit = 2048;
constexpr std::int64_t fastest_limit = 65535;
constexpr std::int64_t motor_is_on = 0x00; // of motor_state, LK lines
constexpr std::int64_t low_voltage_bit = 1;
constexpr std::int64_t over_temperature_bit = 8;

std::int64_t to_raw(double rad, double lsb_deg)
{
    return std::llround(units::deg(rad) / lsb_deg);
}

} // namespace

Driver::Driver(const Spec& spec) : spec_(spec)
{
    const double end = units::rad(static_cast<double>(std::numeric_limits<std::int32_t>::max()) * angle_lsb_deg);
    can_.position_low_rad = -end;
    can_.position_high_rad = end;
    can_.position_step_rad = units::rad(angle_lsb_deg);
    can_.velocity = can_.velocity_limit = true;
    can_.measures_velocity = can_.measures_voltage = can_.measures_temperature = true;
    can_.measures_current = spec_.iq_a().has_value();
}

std::expected<void, Error> Driver::add(wire::Requests& out, std::string_view message,
                                       std::initializer_list<wire::NamedNumber> numbers) const
{
    auto request =
        wire::make_request(spec_.profile.line, message, spec_.id, numbers, spec_.profile.options(), response_time);
    if (!request)
        return std::unexpected(std::move(request.error()));
    out.add(*request);
    return {};
}

std::expected<void, Error> Driver::run(wire::Requests& out)
{
    if (!off_)
        return {};
    // Lines without this message start by any motion command.
    return spec_.profile.line.find("motor-running") != nullptr ? add(out, "motor-running")
                                                               : std::expected<void, Error>{};
}

std::expected<void, Error> Driver::go_to(wire::Requests& out, double position_rad, std::optional<double> limit_rad_s)
{
    if (auto on = run(out); !on)
        return on;
    const std::int64_t angle = to_raw(position_rad, angle_lsb_deg);
    if (!limit_rad_s) {
        if (spec_.profile.line.find("multi-loop-angle") == nullptr)
            return fail(Errc::unsupported, "this firmware line moves to an angle at a named speed only; name one");
        return add(out, "multi-loop-angle", {{"angle", angle}});
    }
    const double lsb = spec_.profile.sent_max_speed_lsb_dps();
    // Rounded down, but for the noise of the conversion: a limit is never exceeded.
    const auto max_speed = static_cast<std::int64_t>(std::floor(units::deg(*limit_rad_s) / lsb + 1e-6));
    if (max_speed < 1 || max_speed > fastest_limit)
        return fail(Errc::out_of_range, fmt::format("a speed limit goes from {:g} to {:g} deg/s on this firmware line",
                                                    lsb, lsb * static_cast<double>(fastest_limit)));
    return add(out, "multi-loop-angle-speed", {{"max_speed", max_speed}, {"angle", angle}});
}

std::expected<void, Error> Driver::turn(wire::Requests& out, double velocity_rad_s)
{
    if (auto on = run(out); !on)
        return on;
    return add(out, "speed-closed-loop", {{"speed", to_raw(velocity_rad_s, speed_lsb_dps)}, {"iq", no_current_limit}});
}

std::expected<wire::Requests, Error> Driver::plan(const actuator::Command& command, const actuator::State&)
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    wire::Requests out;
    std::expected<void, Error> added;
    switch (command.mode) {
    case actuator::Mode::hold:
        // Speed 0 holds with torque on every line, whatever the motor was doing, and needs no position that may be old.
        added = turn(out, 0.0);
        break;
    case actuator::Mode::release:
        added = add(out, "motor-off");
        off_ = true;
        break;
    case actuator::Mode::position:
        added = go_to(out, *command.position_rad, command.velocity_rad_s);
        break;
    case actuator::Mode::velocity:
        added = turn(out, *command.velocity_rad_s);
        break;
    }
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth)
{
    wire::Requests out;
    auto added = add(out, "read-multi-turn-angle");
    if (added)
        added = add(out, "read-status2");
    if (added && depth == actuator::Depth::full)
        added = add(out, "read-status1");
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

double Driver::physical(const wire::MessageInfo& message, const wire::Value& value) const
{
    const auto model = std::span(spec_.overrides).first(spec_.override_count);
    return wire::reading(message, *value.field, spec_.profile.line.overrides, model).physical(value.raw);
}

void Driver::absorb_faults(std::int64_t raw, actuator::State& state) const
{
    state.raw_faults = static_cast<std::uint32_t>(raw);
    state.faults = actuator::Faults{};
    const bool known = spec_.profile.error_bits == ErrorBits::two;
    if (known && (raw & low_voltage_bit) != 0)
        state.faults->set(actuator::Fault::low_voltage);
    if (known && (raw & over_temperature_bit) != 0)
        state.faults->set(actuator::Fault::over_temperature);
    if (known ? (raw & ~(low_voltage_bit | over_temperature_bit)) != 0 : raw != 0)
        state.faults->set(actuator::Fault::unexplained);
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    const auto answer = wire::decode(*asked.message, wire::Direction::reply, reply, asked.options);
    if (!answer)
        return std::unexpected(answer.error());
    state.at = at;
    if (asked.message->name() == "motor-running")
        off_ = false;
    const bool is_angle = asked.message->name() == "read-multi-turn-angle";
    // Only what the motor measured: acknowledgements repeat what was asked.
    const bool measured = answer->values.find("temperature").has_value();
    for (const auto& value : answer->values) {
        const std::string_view name = value.field->name;
        if (is_angle && name == "angle")
            state.position_rad = units::rad(physical(*asked.message, value));
        if (name == "motor_state")
            off_ = value.raw != motor_is_on;
        if (!measured)
            continue;
        if (name == "speed")
            state.velocity_rad_s = units::rad(physical(*asked.message, value));
        else if (name == "temperature")
            state.temperature_c = physical(*asked.message, value);
        else if (name == "voltage")
            state.voltage_v = physical(*asked.message, value);
        else if (name == "iq" && can_.measures_current)
            state.current_a = physical(*asked.message, value);
        else if (name == "error_state")
            absorb_faults(value.raw, state);
    }
    return {};
}

} // namespace sinew::rmd
