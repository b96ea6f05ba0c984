#pragma once
#include "sinew/base/time.hpp"

#include <string_view>

namespace sinew::sim {

/// What a SAM does against too much current and too much heat (L253-255, L448, L714-716). Told once a tick what the
/// last one was like.
class SamProtection
{
public:
    /// What a device was told: its overload limit and that of the 1.8 A rule (S69), where 0 is none; and how much
    /// cooler than the limit it must be to be no longer hot.
    struct Limits {
        double overload_a = 0.0;
        double fixed_a = 0.0;
        double hysteresis_k = 0.0;
    };

    void power_on() { *this = {}; }

    /// `is_driving`: whether the device, not its shorted or open winding, makes the current. True when the motor has
    /// to be let go now.
    bool control(double current_a, double temperature_c, bool is_driving, Limits limits);

    bool is_passive() const { return passive_left_ > Duration{}; } ///< no torque, whatever was commanded
    bool is_hot() const { return is_hot_; }                        ///< no position control
    bool blue_led() const { return blue_left_ > Duration{}; }
    bool red_led() const; ///< blinks
    std::string_view faults() const;

private:
    void let_go(Duration passive);

    Duration over_set_{}; ///< for how long without a break
    Duration over_fixed_{};
    Duration passive_left_{};
    Duration blue_left_{};
    Duration hot_for_{};
    bool is_hot_ = false;
};

} // namespace sinew::sim
