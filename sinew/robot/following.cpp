#include "sinew/robot/following.hpp"

#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::robot {

bool Following::is_blocked(const actuator::Measured<double>& here, double led_to_rad, bool is_behind)
{
    if (!is_behind || !here) {
        furthest_ = {};
        return false;
    }
    const double sense = std::copysign(1.0, led_to_rad - *here);
    if (!furthest_ || sense * (*here - *furthest_) > progress_rad)
        furthest_ = here;
    return here.at() - furthest_.at() >= patience;
}

std::string does_not_follow(double here_rad, double led_to_rad)
{
    return fmt::format("it is at {:.2f} deg and does not follow to {:.2f} deg; is it blocked?", units::deg(here_rad),
                       units::deg(led_to_rad));
}

} // namespace sinew::robot
