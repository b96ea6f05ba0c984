#pragma once
#include "sinew/sim/firmware/sam_settings.hpp"

namespace sinew::sim {

/// The position control of a SAM (L225-239): a PID on the position error that puts out PWM duty, once a tick. P alone
/// swings and gives way to a load, D damps, I takes what a load leaves of the error.
class SamPositionLoop
{
public:
    /// Duty for each radian of error at P = 1. ASSUMED, like all of its figures.
    static constexpr double p_duty_per_rad = 0.076;

    /// Forgets what I has gathered. `position_rad`: where the shaft is.
    void begin(double position_rad)
    {
        integral_ = 0.0;
        before_rad_ = position_rad;
    }

    /// Duty within ±`limit` from where the shaft should be, and how fast, and where it is one tick after the last call.
    double duty(double reference_rad, double reference_rad_s, double position_rad, const SamGains& gains, double limit);

private:
    double integral_ = 0.0; ///< duty
    double before_rad_ = 0.0;
};

} // namespace sinew::sim
