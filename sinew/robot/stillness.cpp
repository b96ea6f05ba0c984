#include "sinew/robot/stillness.hpp"

#include "sinew/base/seconds.hpp"

#include <algorithm>

namespace sinew::robot {
namespace {

/// What is less than this is the rounding of a conversion.
constexpr double noise_rad = 1e-9;
/// Who moves further than he may in this time begins anew.
constexpr double memory_s = 0.3;

} // namespace

/// Room for two steps of flicker, however coarse they are.
double Stillness::most_rad() const
{
    return std::max(2.0 * step_rad_, rest_rad_s * memory_s - step_rad_) + noise_rad;
}

void Stillness::look(const actuator::Measured<double>& here)
{
    if (!here || (last_ && last_.at() == here.at()))
        return;
    last_ = here;
    ++looks_;
    low_rad_ = std::min(low_rad_, *here);
    high_rad_ = std::max(high_rad_, *here);
    if (first_ && high_rad_ - low_rad_ <= most_rad())
        return;
    first_ = here;
    looks_ = 1;
    low_rad_ = high_rad_ = *here;
}

bool Stillness::is_at_rest() const
{
    if (looks_ < fewest_looks)
        return false;
    const Duration time = last_.at() - first_.at();
    return time >= least && high_rad_ - low_rad_ + step_rad_ <= rest_rad_s * seconds(time) + noise_rad;
}

} // namespace sinew::robot
