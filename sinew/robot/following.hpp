#pragma once
#include "sinew/actuator/measured.hpp"
#include "sinew/base/time.hpp"

#include <string>

namespace sinew::robot {

/// Whether a joint that is led comes after, look by look: the one place that says when it counts as blocked.
class Following
{
public:
    /// Behind for so long and no further than before, it is.
    static constexpr Duration patience = std::chrono::seconds{1};
    static constexpr double progress_rad = 0.0175; ///< 1 deg: less in that time is standing still

    /// A look: where it is, where it is led to, and whether it is as far behind as it may be. To fall back, and to come
    /// back after that, is not to get on: a servo may let go of what blocks it, for a moment, again and again.
    bool is_blocked(const actuator::Measured<double>& here, double led_to_rad, bool is_behind);

private:
    actuator::Measured<double> furthest_; ///< so far it has come, then
};

/// What to say of one that is.
std::string does_not_follow(double here_rad, double led_to_rad);

} // namespace sinew::robot
