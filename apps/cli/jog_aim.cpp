#include "apps/cli/jog_aim.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::cli {
double JogAim::faster_rad_s(double speed_rad_s) const
{
    const double most = joint_ != nullptr ? joint_->velocity_max_rad_s.value_or(INFINITY) : INFINITY;
    return std::min(speed_factor * speed_rad_s, most);
}

double JogAim::low_rad() const
{
    return joint_ != nullptr ? joint_->position_min_rad.value_or(-INFINITY) : -INFINITY;
}

double JogAim::high_rad() const
{
    return joint_ != nullptr ? joint_->position_max_rad.value_or(INFINITY) : INFINITY;
}

std::optional<double> JogAim::step(double here_rad, int direction, double step_rad, double ahead_rad)
{
    const double from = target_rad_.value_or(here_rad);
    if (direction > 0 ? from > high_rad() : from < low_rad())
        return std::nullopt;
    const double low = std::min(low_rad(), from), high = std::max(high_rad(), from);
    const double target = std::clamp(from + direction * step_rad, low, high);
    // It would leap when it comes free.
    target_rad_ = std::clamp(target, here_rad - ahead_rad, here_rad + ahead_rad);
    return target_rad_;
}

} // namespace sinew::cli
