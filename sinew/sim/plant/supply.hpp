#pragma once
#include "sinew/sim/plant/plant.hpp"

#include <algorithm>

namespace sinew::sim {

/// A supply shared by actuators: a voltage behind an internal resistance, with a capacitor that takes the edge off.
class Supply
{
public:
    Supply(double nominal_v, double internal_ohm) : nominal_v_(nominal_v), ohm_(internal_ohm), voltage_v_(nominal_v) {}

    void begin() { current_a_ = 0.0; }
    /// What an actuator took in this tick; below 0: what it fed back.
    void take(double current_a) { current_a_ += current_a; }
    /// One tick with all that was taken. The voltage never falls below 0.
    void run()
    {
        const double settled = set_v() - ohm_ * current_a_;
        voltage_v_ = std::max(0.0, voltage_v_ + (settled - voltage_v_) * tick_s / (smoothing_s + tick_s));
    }
    /// Another voltage than the nominal one, such as 0; until `restore`.
    void set(double voltage_v)
    {
        forced_v_ = voltage_v;
        is_forced_ = true;
    }
    void restore() { is_forced_ = false; }

    double voltage_v() const { return voltage_v_; }
    double current_a() const { return current_a_; } ///< of the last tick
    double nominal_v() const { return nominal_v_; }

private:
    static constexpr double smoothing_s = 0.002; ///< ASSUMED: resistance times capacitor

    double set_v() const { return is_forced_ ? forced_v_ : nominal_v_; }

    double nominal_v_;
    double ohm_;
    double voltage_v_;
    double forced_v_ = 0.0;
    double current_a_ = 0.0;
    bool is_forced_ = false;
};

} // namespace sinew::sim
