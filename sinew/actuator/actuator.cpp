#include "sinew/actuator/actuator.hpp"

namespace sinew::actuator {

std::optional<double> State::position_rad_at(TimePoint t, Duration furthest) const
{
    if (!position_rad || !velocity_rad_s)
        return {};
    const Duration on = t - position_rad.at();
    const Duration apart = velocity_rad_s.at() - position_rad.at();
    if (std::chrono::abs(on) > furthest || std::chrono::abs(apart) > furthest)
        return {};
    return *position_rad + *velocity_rad_s * seconds(on);
}

std::string_view to_word(Mode mode)
{
    switch (mode) {
    case Mode::hold:
        return "hold";
    case Mode::release:
        return "release";
    case Mode::brake:
        return "brake";
    case Mode::position:
        return "position";
    case Mode::velocity:
        return "velocity";
    case Mode::current:
        return "current";
    case Mode::torque:
        return "torque";
    case Mode::duty:
        return "duty";
    }
    return "?";
}

std::string_view to_word(Fault fault)
{
    switch (fault) {
    case Fault::over_temperature:
        return "over temperature";
    case Fault::low_voltage:
        return "low voltage";
    case Fault::high_voltage:
        return "high voltage";
    case Fault::driver_over_temperature:
        return "driver over temperature";
    case Fault::over_current:
        return "over-current";
    case Fault::short_circuit:
        return "short circuit";
    case Fault::stall:
        return "stall";
    case Fault::input_lost:
        return "input lost";
    case Fault::unexplained:
        return "unexplained";
    }
    return "?";
}

} // namespace sinew::actuator
