#include "sinew/robot/following.hpp"

#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::robot {

bool Following::is_blocked(const actuator::Measured<double>& here, bool is_behind)
{
    if (!is_behind || !here) {
        stands_at_ = {};
        return false;
    }
    if (!stands_at_ || std::abs(*here - *stands_at_) > progress_rad)
        stands_at_ = here;
    return here.at() - stands_at_.at() >= patience;
}

std::string does_not_follow(double here_rad, double led_to_rad)
{
    return fmt::format("it is at {:.2f} deg and does not follow to {:.2f} deg; is it blocked?", units::deg(here_rad),
                       units::deg(led_to_rad));
}

} // namespace sinew::robot
