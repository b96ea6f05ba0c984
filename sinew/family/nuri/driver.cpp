#include "sinew/family/nuri/driver.hpp"

#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/nuri/messages.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::nuri {
namespace {

constexpr double position_lsb_deg = 0.01;    // items 1, 2, 16
constexpr double far_position_lsb_deg = 0.1; // item 17 (N06)
constexpr double speed_lsb_rpm = 0.1;
constexpr double current_lsb_a = 0.1;
constexpr std::int64_t largest = 65533; // N04
/// The speed of the manual's own example (L8), where a caller names none: mode 1 has no "as fast as possible".
constexpr double default_speed_rad_s = units::rad_s_from_rpm(5.0);
/// Arrival time of a speed, in 0.1 s: that of the manual's example (L22).
constexpr std::int64_t speed_arrival_time = 10;
constexpr std::int64_t shortest_arrival_time = 1;

/// Rounded down, but for the noise of the conversion: nothing turns faster than asked.
std::expected<std::int64_t, Error> speed_raw(double speed_rad_s, std::int64_t least)
{
    const auto raw = static_cast<std::int64_t>(std::floor(units::rpm(std::abs(speed_rad_s)) / speed_lsb_rpm + 1e-6));
    if (raw < least || raw > largest)
        return fail(Errc::out_of_range,
                    fmt::format("a speed goes from {:g} to {:g} deg/s",
                                units::deg(units::rad_s_from_rpm(speed_lsb_rpm)),
                                units::deg(units::rad_s_from_rpm(static_cast<double>(largest) * speed_lsb_rpm))));
    return raw;
}

} // namespace

Driver::Driver(const Spec& spec) : spec_(spec)
{
    const double end = units::rad(static_cast<double>(largest) * position_lsb_deg);
    can_.position_low_rad = -end;
    can_.position_high_rad = end;
    can_.position_step_rad = units::rad(position_lsb_deg);
    can_.velocity = can_.velocity_limit = true;
    can_.measures_velocity = can_.measures_current = true;
}

std::int64_t Driver::direction(double value) const
{
    const bool counter_clockwise = (value >= 0.0) == spec_.profile.ccw_positive;
    return static_cast<std::int64_t>(counter_clockwise ? Rotation::counter_clockwise : Rotation::clockwise);
}

double Driver::signed_by(std::int64_t direction, double magnitude) const
{
    const bool counter_clockwise = direction == static_cast<std::int64_t>(Rotation::counter_clockwise);
    return counter_clockwise == spec_.profile.ccw_positive ? magnitude : -magnitude;
}

std::expected<void, Error> Driver::add(wire::Requests& out, std::string_view message,
                                       std::initializer_list<wire::NamedNumber> numbers) const
{
    auto request = wire::make_request(spec_.profile.line, message, spec_.id, numbers, spec_.profile.options(),
                                      spec_.profile.response_time());
    if (!request)
        return std::unexpected(std::move(request.error()));
    out.add(*request);
    return {};
}

std::expected<void, Error> Driver::switch_on(wire::Requests& out)
{
    if (!off_)
        return {};
    off_ = false;
    return add(out, "set-control-on-off", {{"control", static_cast<std::int64_t>(Control::on)}});
}

std::expected<void, Error> Driver::go_to(wire::Requests& out, double position_rad, double speed_rad_s)
{
    // What is an absolute angle here would be a turn from where the shaft is (L77).
    if (!relative_)
        return fail(Errc::unsupported, "whether positions are absolute is not known yet; read its state first");
    if (*relative_)
        return fail(Errc::unsupported, "the device is set to relative positions; set position_mode=absolute first");
    const auto speed = speed_raw(speed_rad_s, 1);
    if (!speed)
        return std::unexpected(speed.error());
    if (auto on = switch_on(out); !on)
        return on;
    return add(out, "position-speed-control",
               {{"position_direction", direction(position_rad)},
                {"position", std::llround(std::abs(units::deg(position_rad)) / position_lsb_deg)},
                {"speed", *speed}});
}

std::expected<void, Error> Driver::turn(wire::Requests& out, double velocity_rad_s, std::int64_t arrival_time)
{
    const auto speed = speed_raw(velocity_rad_s, velocity_rad_s == 0.0 ? 0 : 1);
    if (!speed)
        return std::unexpected(speed.error());
    if (auto on = switch_on(out); !on)
        return on;
    return add(out, "accel-speed-control",
               {{"speed_direction", direction(velocity_rad_s)}, {"speed", *speed}, {"arrival_time", arrival_time}});
}

std::expected<wire::Requests, Error> Driver::plan(const actuator::Command& command, const actuator::State&)
{
    if (auto fine = actuator::check(command, can_, spec_.id); !fine)
        return std::unexpected(std::move(fine.error()));
    wire::Requests out;
    std::expected<void, Error> added;
    switch (command.mode) {
    case actuator::Mode::hold:
        // Not by position: feedback ends at 655.33 deg (N17), and in relative mode it would be a turn.
        added = turn(out, 0.0, shortest_arrival_time);
        break;
    case actuator::Mode::release:
        added = add(out, "set-control-on-off", {{"control", static_cast<std::int64_t>(Control::off)}});
        off_ = off_ || added.has_value();
        break;
    case actuator::Mode::position:
        added = go_to(out, *command.position_rad, command.velocity_rad_s.value_or(default_speed_rad_s));
        break;
    case actuator::Mode::velocity:
        added = turn(out, *command.velocity_rad_s, speed_arrival_time);
        break;
    }
    if (!added)
        return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<wire::Requests, Error> Driver::plan_read(actuator::Depth depth)
{
    wire::Requests out;
    if (auto added = add(out, "request-position-feedback"); !added)
        return std::unexpected(std::move(added.error()));
    // Once in any case: a position means something else in relative mode.
    if (depth == actuator::Depth::motion && !relative_)
        if (auto added = add(out, "request-position-mode-feedback"); !added)
            return std::unexpected(std::move(added.error()));
    if (depth == actuator::Depth::full)
        for (const auto* message :
             {"request-speed-feedback", "request-control-on-off-feedback", "request-position-mode-feedback"})
            if (auto added = add(out, message); !added)
                return std::unexpected(std::move(added.error()));
    return out;
}

std::expected<void, Error> Driver::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at,
                                          actuator::State& state)
{
    if (!asked.message->reply.exists())
        return {};
    const auto answer = wire::decode(*asked.message, wire::Direction::reply, reply, asked.options);
    if (!answer)
        return std::unexpected(answer.error());
    const auto value = [&](std::string_view name) { return answer->values.find(name); };
    state.at = at;
    if (const auto sign = value("position_direction")) {
        state.position_rad = signed_by(*sign, units::rad(static_cast<double>(*value("position")) * position_lsb_deg));
        // No sign of the speed travels here: only standing still is certain.
        if (*value("speed") == 0)
            state.velocity_rad_s = 0.0;
        else
            state.velocity_rad_s.reset();
    }
    if (const auto sign = value("speed_direction")) {
        const double speed = units::rad_s_from_rpm(static_cast<double>(*value("speed")) * speed_lsb_rpm);
        state.velocity_rad_s = signed_by(*sign, speed);
        // Beyond the range of position feedback only this one still tells how far, but without a sign (N17).
        const double far_rad = units::rad(static_cast<double>(*value("position")) * far_position_lsb_deg);
        if (state.position_rad && far_rad > *can_.position_high_rad)
            state.position_rad = std::copysign(far_rad, *state.position_rad);
    }
    if (const auto current = value("current"))
        state.current_a = static_cast<double>(*current) * current_lsb_a;
    if (const auto switched = value("control"))
        off_ = *switched == static_cast<std::int64_t>(Control::off);
    if (const auto mode = value("position_mode"))
        relative_ = *mode == static_cast<std::int64_t>(PositionMode::relative);
    return {};
}

} // namespace sinew::nuri
