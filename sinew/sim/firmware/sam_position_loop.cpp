#include "sinew/sim/firmware/sam_position_loop.hpp"

#include "sinew/sim/plant/plant.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

// ASSUMED, all of these: gains have no unit in the manual. With the assumed inertias these make the default gains
// critically damped or a little slower, and P alone swing about three times.
constexpr double i_duty_per_rad_s = 2.5;
constexpr double d_duty_s_per_rad = 0.0053;
// ASSUMED: what it adds to overcome the friction of a shaft without load, but for an error that it takes for none.
// Without the first it would stop short of every target, without the second never rest.
constexpr double friction_duty = 0.04;
constexpr double near_enough_rad = 2.5e-5;

} // namespace

double SamPositionLoop::duty(double reference_rad, double reference_rad_s, double position_rad, const SamGains& gains,
                             double limit)
{
    const double error = reference_rad - position_rad;
    const double error_rad_s = reference_rad_s - (position_rad - before_rad_) / tick_s;
    before_rad_ = position_rad;
    if (gains.i == 0)
        integral_ = 0.0;
    double friction = 0.0;
    if (std::abs(error) > near_enough_rad) {
        friction = std::copysign(friction_duty, error);
        integral_ = std::clamp(integral_ + gains.i * i_duty_per_rad_s * error * tick_s, -limit, limit);
    }
    const double wanted =
        gains.p * p_duty_per_rad * error + integral_ + gains.d * d_duty_s_per_rad * error_rad_s + friction;
    return std::clamp(wanted, -limit, limit);
}

} // namespace sinew::sim
