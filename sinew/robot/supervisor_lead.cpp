#include "sinew/robot/stillness.hpp"
#include "sinew/robot/supervisor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

/// How far a joint may be led ahead of where it is, and whether it comes.
namespace sinew::robot {

/// From the measured position; it has been turning since.
double Supervisor::lead_rad(TimePoint now) const
{
    const double turned = rules_.limits.velocity_max_rad_s.value_or(0.0) * std::max(0.0, seconds(now - seen_.at()));
    return rules_.lead_max_rad.value_or(std::numeric_limits<double>::infinity()) + turned;
}

double Supervisor::within_lead_rad(double position_rad, TimePoint now) const
{
    if (!reference_rad_ || !seen_)
        return position_rad;
    const double most = comes_ ? lead_rad(now) / 2.0 : lead_rad(now);
    return std::clamp(position_rad, std::min(*reference_rad_, *seen_ - most), std::max(*reference_rad_, *seen_ + most));
}

/// What comes free has all its lead before it; it keeps what it trails behind at its greatest velocity.
double Supervisor::nearest_lead_rad(double position_rad, TimePoint now) const
{
    const double within = within_lead_rad(position_rad, now);
    if (!leaps())
        return within;
    constexpr double anywhere = std::numeric_limits<double>::infinity();
    const double kept = std::clamp(*seen_ + std::copysign(rules_.trail_rad, velocity_rad_s_),
                                   reach_.low_rad.value_or(-anywhere), reach_.high_rad.value_or(anywhere));
    return velocity_rad_s_ > 0.0 ? std::min(within, kept) : std::max(within, kept);
}

/// Only what has come further than where its lead ended does. A velocity is rough, and a servo whose overload let it
/// fall comes back fast: to take its lead away from either would go on for ever.
bool Supervisor::leaps() const
{
    const auto& most = rules_.limits.velocity_max_rad_s;
    if (!most || !stood_rad_)
        return false;
    const double sense = std::copysign(1.0, *reference_rad_ - *seen_);
    return sense * (*seen_ - *stood_rad_) > Following::progress_rad &&
           sense * velocity_rad_s_ > *most * velocity_tolerance + rest_rad_s;
}

void Supervisor::see_where_it_stands()
{
    const double gap = *reference_rad_ - *seen_;
    if (std::abs(gap) >= *rules_.lead_max_rad) {
        const bool is_further = !stood_rad_ || (*seen_ - *stood_rad_) * gap > 0.0;
        stood_rad_ = is_further ? *seen_ : *stood_rad_;
    } else if (std::abs(gap) <= rules_.trail_rad) {
        stood_rad_.reset();
    }
}

bool Supervisor::is_behind(double position_rad, TimePoint now) const
{
    return seen_ && std::abs(position_rad - *seen_) > lead_rad(now);
}

/// One that gets on no more, such as under its load, is led on again as far as its lead goes.
void Supervisor::see_whether_it_comes()
{
    if (!is_commanded_ || !rules_.lead_max_rad) {
        stood_rad_.reset();
        return;
    }
    see_where_it_stands();
    if (!mark_ || std::abs(*seen_ - *mark_) > Following::progress_rad)
        mark_ = seen_;
    const double gap = std::abs(*reference_rad_ - *seen_);
    const bool stands = seen_.at() - mark_.at() >= lasting;
    comes_ = gap >= *rules_.lead_max_rad || (comes_ && !stands && gap > *rules_.lead_max_rad / 2.0);
}

/// Of a joint that goes at once wherever it is led, as long as it is not led on.
Finding Supervisor::judge_lead(const actuator::Command& running)
{
    const bool is_led =
        running.mode == actuator::Mode::position && !limits_velocity_ && is_commanded_ && rules_.lead_max_rad;
    if (!following_.is_blocked(seen_, reference_rad_.value_or(0.0), is_led && comes_))
        return {};
    return finding(Measure::end, Errc::timeout, does_not_follow(*seen_, *reference_rad_));
}

} // namespace sinew::robot
