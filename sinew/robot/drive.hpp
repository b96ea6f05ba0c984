#pragma once
#include "sinew/actuator/actuator.hpp"

namespace sinew::robot {

/// What nobody acknowledges is said again after so long.
inline constexpr Duration repetition = std::chrono::milliseconds{250};

/// Whether a device that hears nothing more goes on with it without end.
inline bool is_endless(actuator::Mode mode)
{
    using enum actuator::Mode;
    return mode == velocity || mode == current || mode == torque || mode == duty;
}

/// In which sense a command without end drives; 0: it does not.
inline double sense_of(const actuator::Command& command)
{
    switch (command.mode) {
    case actuator::Mode::velocity:
        return command.velocity_rad_s.value_or(0.0);
    case actuator::Mode::current:
        return command.current_a.value_or(0.0);
    case actuator::Mode::torque:
        return command.torque_nm.value_or(0.0);
    case actuator::Mode::duty:
        return command.duty.value_or(0.0);
    default:
        return 0.0;
    }
}

/// Whether it keeps the shaft where it is, with torque. A velocity of 0 is no other frame of an RMD than a hold.
inline bool is_to_stand(const actuator::Command& command)
{
    using enum actuator::Mode;
    return command.mode == hold || (command.mode == velocity && sense_of(command) == 0.0);
}

/// Whether it drives nothing, wherever the shaft is and whatever it did before.
inline bool lets_go(const actuator::Command& command)
{
    using enum actuator::Mode;
    const bool is_push = command.mode == current || command.mode == torque || command.mode == duty;
    return command.mode == release || command.mode == brake || (is_push && sense_of(command) == 0.0);
}

} // namespace sinew::robot
