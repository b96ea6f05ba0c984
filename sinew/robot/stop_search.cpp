#include "sinew/robot/stop_search.hpp"

#include "sinew/base/seconds.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <utility>

namespace sinew::robot {

double home_velocity_rad_s(const config::Joint& joint)
{
    return std::min(joint.home.velocity_rad_s, joint.velocity_max_rad_s.value_or(joint.home.velocity_rad_s));
}

double longest_search_rad(const config::Joint& joint)
{
    if (joint.home.travel_max_rad)
        return *joint.home.travel_max_rad;
    if (!joint.position_min_rad || !joint.position_max_rad)
        return 2.0 * std::numbers::pi + beyond_range_rad;
    return std::max(*joint.position_max_rad, joint.home.position_rad) -
           std::min(*joint.position_min_rad, joint.home.position_rad) + beyond_range_rad;
}

StopSearch::StopSearch(const config::Joint& joint, double from_rad, TimePoint begin)
    : velocity_rad_s_(home_velocity_rad_s(joint)), longest_rad_(longest_search_rad(joint)), from_rad_(from_rad),
      looked_at_(begin), since_(begin + gets_going),
      // What gets along by less has found its stop, if it was measured.
      until_(begin + gets_going + stand_still + from_seconds(longest_rad_ / (share_of_way * velocity_rad_s_)))
{
}

StopSearch::Seen StopSearch::look(const actuator::Measured<double>& here, const actuator::Measured<double>& current_a,
                                  TimePoint now)
{
    if (now >= until_)
        return Seen::too_far;
    if (!here || here.at() < looked_at_)
        return Seen::way;
    if (here.at() > measured_at_)
        gap_ = here.at() - std::exchange(measured_at_, here.at());
    if (current_a && std::abs(*current_a) < least_push_a)
        idle_at_ = std::max(idle_at_, current_a.at());
    const double way = std::abs(*here - from_rad_);
    // An encoder that begins anew after a turn has not turned back.
    const double travelled = travelled_rad_ + std::min(way, 2.0 * velocity_rad_s_ * seconds(here.at() - looked_at_));
    const Duration time = here.at() - since_;
    if (time >= stand_still) {
        const bool stands = way < share_of_way * velocity_rad_s_ * seconds(time);
        const bool is_idle = here.at() - idle_at_ < std::max(pushes_for, 5 * gap_ / 2);
        if (stands && (!is_idle || stood_idle_))
            return Seen::stop;
        stood_idle_ = stands;
        from_rad_ = *here;
        travelled_rad_ = travelled;
        looked_at_ = here.at();
        since_ = stands ? here.at() + gets_going : here.at();
    }
    return travelled >= longest_rad_ ? Seen::too_far : Seen::way;
}

std::string StopSearch::says(const std::string& joint) const
{
    return fmt::format("{} has turned as far as it may for its stop, {:.0f} deg, and found none; is `direction` of its "
                       "home right? travel_max_deg of its home lets it turn further",
                       joint, units::deg(longest_rad_));
}

} // namespace sinew::robot
