#include "sinew/actuator/check.hpp"

#include "sinew/base/units.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace sinew::actuator {
namespace {

using Checked = std::expected<void, Error>;

/// One value of a command, and what a mode makes of it.
struct Part {
    std::string_view name;
    std::optional<double> value;
    bool needed = false;
    Ability taken = {"the mode does not take it"};
};

/// All values of a command in the light of its mode.
std::array<Part, 7> parts_of(const Command& c, const Capabilities& can)
{
    const bool position = c.mode == Mode::position, velocity = c.mode == Mode::velocity;
    const Ability no = Part{}.taken;
    const auto when = [&](bool mine) { return mine ? able : no; };
    const auto duration = c.duration ? std::optional(seconds(*c.duration)) : std::nullopt;
    return {{{"position_rad", c.position_rad, position, when(position)},
             {"velocity_rad_s", c.velocity_rad_s, velocity,
              position   ? can.velocity_limit
              : velocity ? able
                         : no},
             {"current_a", c.current_a, c.mode == Mode::current,
              c.mode == Mode::current ? able
              : velocity              ? can.current_limit
                                      : no},
             {"torque_nm", c.torque_nm, c.mode == Mode::torque, when(c.mode == Mode::torque)},
             {"duty", c.duty, c.mode == Mode::duty, when(c.mode == Mode::duty)},
             {"duration", duration, false,
              position   ? can.timed
              : velocity ? can.timed_velocity
                         : no},
             {"resolution_rad", c.resolution_rad, false, when(position)}}};
}

Ability ability(Mode mode, const Capabilities& can)
{
    switch (mode) {
    case Mode::velocity:
        return can.velocity;
    case Mode::brake:
        return can.brake;
    case Mode::current:
        return can.current;
    case Mode::torque:
        return can.torque;
    case Mode::duty:
        return can.duty;
    case Mode::hold:
    case Mode::release:
    case Mode::position:
        break;
    }
    return able;
}

std::string end(const std::optional<double>& rad, const char* none)
{
    return rad ? fmt::format("{:.2f} deg", units::deg(*rad)) : none;
}

Checked in_reach(double position, const std::optional<double>& low, const std::optional<double>& high,
                 std::string_view what, int id)
{
    if ((low && position < *low) || (high && position > *high))
        return refuse(Errc::out_of_range, id,
                      fmt::format("position {:.2f} deg is outside {}, {} … {}", units::deg(position), what,
                                  end(low, "no end"), end(high, "no end")));
    return {};
}

Checked at_most(std::optional<double> value, std::optional<double> most, std::string_view unit, std::string_view whose,
                int id)
{
    if (value && most && std::abs(*value) > *most)
        return refuse(Errc::out_of_range, id,
                      fmt::format("{:g} {} is more than the {:g} {} {}", std::abs(*value), unit, *most, unit, whose));
    return {};
}

std::optional<double> in_deg(std::optional<double> rad)
{
    return rad ? std::optional(units::deg(*rad)) : std::nullopt;
}

Checked above_zero(std::optional<double> value, std::string_view what, int id)
{
    if (value && *value <= 0.0)
        return refuse(Errc::out_of_range, id, fmt::format("the {} must be above 0", what));
    return {};
}

/// The first that is wrong.
Checked first_of(std::initializer_list<Checked> all)
{
    for (const auto& one : all)
        if (!one)
            return one;
    return {};
}

Checked check_parts(const Command& command, const Capabilities& can, int id)
{
    for (const Part& part : parts_of(command, can)) {
        if (part.needed && !part.value)
            return refuse(Errc::missing_field, id, fmt::format("mode {} needs {}", to_word(command.mode), part.name));
        if (part.value && !part.taken)
            return refuse(Errc::unsupported, id,
                          fmt::format("mode {} with {}: {}", to_word(command.mode), part.name, part.taken.why_not));
        if (part.value && !std::isfinite(*part.value))
            return refuse(Errc::out_of_range, id, fmt::format("{} must be a finite number", part.name));
    }
    return {};
}

} // namespace

std::unexpected<Error> refuse(Errc code, int id, std::string why)
{
    Error error{.code = code, .id = id};
    error.detail = std::move(why);
    return std::unexpected(std::move(error));
}

Checked check(const Command& command, const Capabilities& can, int id)
{
    if (const Ability mode = ability(command.mode, can); !mode)
        return refuse(Errc::unsupported, id, fmt::format("mode {}: {}", to_word(command.mode), mode.why_not));
    if (command.mode == Mode::hold || command.mode == Mode::release || command.mode == Mode::brake)
        return {};
    if (auto fine = check_parts(command, can, id); !fine)
        return fine;
    const std::string_view own = "of the actuator";
    // Not by ?:, of which g++ 12 at -O3 says that the value may be uninitialised.
    std::optional<double> duration_max;
    if (can.duration_max)
        duration_max = seconds(*can.duration_max);
    std::optional<double> duration;
    if (command.duration)
        duration = seconds(*command.duration);
    if (command.mode == Mode::position && command.velocity_rad_s && command.duration)
        return refuse(Errc::bad_argument, id, "a move has a velocity or a duration, not both");
    return first_of({command.position_rad ? in_reach(*command.position_rad, can.position_low_rad, can.position_high_rad,
                                                     "what the actuator reaches", id)
                                          : Checked{},
                     command.mode == Mode::position
                         ? above_zero(command.velocity_rad_s, "velocity of a move to a position", id)
                         : Checked{},
                     command.mode == Mode::velocity ? above_zero(command.current_a, "current limit", id) : Checked{},
                     above_zero(duration, "duration", id), above_zero(command.resolution_rad, "resolution", id),
                     at_most(in_deg(command.velocity_rad_s), in_deg(can.velocity_max_rad_s), "deg/s", own, id),
                     at_most(command.current_a, can.current_max_a, "A", own, id),
                     at_most(command.duty, can.duty_max, "duty", own, id),
                     at_most(duration, duration_max, "s", "that the protocol can carry", id)});
}

Checked check(const Command& command, const Limits& limits, const State& state, int id)
{
    if (command.mode == Mode::hold || command.mode == Mode::release || command.mode == Mode::brake)
        return {};
    const std::string_view own = "allowed";
    if (state.temperature_c && limits.temperature_max_c && *state.temperature_c >= *limits.temperature_max_c)
        return refuse(Errc::out_of_range, id,
                      fmt::format("it is {:.0f} °C hot, {:.0f} °C are allowed; let it cool", *state.temperature_c,
                                  *limits.temperature_max_c));
    const auto mean_speed = [&]() -> std::optional<double> {
        if (command.mode != Mode::position || !command.duration || !state.position_rad)
            return {};
        return (*command.position_rad - *state.position_rad) / seconds(*command.duration);
    }();
    if (command.mode == Mode::position && limits.step_max_rad) {
        if (!state.position_rad)
            return refuse(Errc::unsupported, id, "a limit of the step needs the measured position; read its state");
        const double step = *command.position_rad - *state.position_rad;
        if (auto fine = at_most(units::deg(step), in_deg(limits.step_max_rad), "deg", "allowed in one step", id); !fine)
            return fine;
    }
    return first_of({command.mode == Mode::position ? in_reach(*command.position_rad, limits.position_low_rad,
                                                               limits.position_high_rad, "what is allowed", id)
                                                    : Checked{},
                     at_most(in_deg(command.velocity_rad_s), in_deg(limits.velocity_max_rad_s), "deg/s", own, id),
                     at_most(in_deg(mean_speed), in_deg(limits.velocity_max_rad_s), "deg/s", own, id),
                     at_most(command.current_a, limits.current_max_a, "A", own, id),
                     at_most(command.torque_nm, limits.torque_max_nm, "Nm", own, id),
                     at_most(command.duty, limits.duty_max, "duty", own, id)});
}

} // namespace sinew::actuator
