#include "sinew/actuator/check.hpp"

#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::actuator {
namespace {

std::unexpected<Error> refuse(Errc code, int id, std::string why)
{
    Error error{.code = code, .id = id};
    error.detail = std::move(why);
    return std::unexpected(std::move(error));
}

std::string end(const std::optional<double>& rad, const char* none)
{
    return rad ? fmt::format("{:.2f} deg", units::deg(*rad)) : none;
}

std::expected<void, Error> check_position(const Command& command, const Capabilities& can, int id)
{
    if (!command.position_rad)
        return refuse(Errc::missing_field, id, "mode position needs position_rad");
    const double position = *command.position_rad;
    if ((can.position_low_rad && position < *can.position_low_rad) ||
        (can.position_high_rad && position > *can.position_high_rad))
        return refuse(Errc::out_of_range, id,
                      fmt::format("position {:.2f} deg is outside what the actuator reaches, {} … {}",
                                  units::deg(position), end(can.position_low_rad, "no end"),
                                  end(can.position_high_rad, "no end")));
    if (command.velocity_rad_s && !can.velocity_limit)
        return refuse(Errc::unsupported, id,
                      "the protocol has no documented speed for a move to a position; leave it out");
    if (command.velocity_rad_s && *command.velocity_rad_s <= 0.0)
        return refuse(Errc::out_of_range, id, "the velocity of a move to a position must be above 0");
    return {};
}

} // namespace

std::expected<void, Error> check(const Command& command, const Capabilities& can, int id)
{
    for (const auto& value : {command.position_rad, command.velocity_rad_s})
        if (value && !std::isfinite(*value))
            return refuse(Errc::out_of_range, id, "positions and velocities must be finite numbers");
    if (command.mode == Mode::position) {
        if (auto fine = check_position(command, can, id); !fine)
            return fine;
    }
    if (command.mode == Mode::velocity) {
        if (!can.velocity)
            return refuse(Errc::unsupported, id, "the actuator cannot turn at a velocity");
        if (!command.velocity_rad_s)
            return refuse(Errc::missing_field, id, "mode velocity needs velocity_rad_s");
    }
    if (command.velocity_rad_s && can.velocity_max_rad_s && std::abs(*command.velocity_rad_s) > *can.velocity_max_rad_s)
        return refuse(Errc::out_of_range, id,
                      fmt::format("{:.1f} deg/s is more than the {:.1f} deg/s of the actuator",
                                  units::deg(*command.velocity_rad_s), units::deg(*can.velocity_max_rad_s)));
    return {};
}

} // namespace sinew::actuator
