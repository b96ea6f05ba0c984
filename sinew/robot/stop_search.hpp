#pragma once
#include "sinew/actuator/measured.hpp"

#include <cmath>

namespace sinew::robot {

/// Whether a joint that turns against its stop has found it: it gets along by less than a share of what it would in the
/// time of the measurements. Pure; the caller turns it.
class StopSearch
{
public:
    /// So long it must get along by less than a share of its way before something is in it.
    static constexpr Duration stand_still = std::chrono::milliseconds{200};
    static constexpr Duration gets_going = std::chrono::seconds{1};
    static constexpr double share_of_way = 0.3;

    StopSearch() = default;
    StopSearch(double from_rad, TimePoint begin) : from_rad_(from_rad), since_(begin + gets_going) {}

    /// In the time of the measurements: one that is missing must not pass for a joint that does not get along.
    bool found(const actuator::Measured<double>& here, double velocity_rad_s)
    {
        if (!here || here.at() - since_ < stand_still)
            return false;
        const double most = velocity_rad_s * seconds(here.at() - since_);
        const bool stands = std::abs(*here - from_rad_) < share_of_way * most;
        from_rad_ = *here;
        since_ = here.at();
        return stands;
    }

private:
    double from_rad_ = 0.0;
    TimePoint since_{};
};

} // namespace sinew::robot
