#pragma once
#include "sinew/actuator/measured.hpp"
#include "sinew/base/units.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/robot/drive.hpp"

#include <string>

namespace sinew::robot {

/// Of the routine of `[joint.NAME.home]` and of the way to 0: no faster than the joint may turn.
double home_velocity_rad_s(const config::Joint& joint);

/// So far a joint that finds no stop is turned: `travel_max_deg` of its home; else its range, which its stop belongs
/// to, and `beyond_range_rad`; a turn in place of the range where it has no limits.
double longest_search_rad(const config::Joint& joint);

/// It may begin on the other stop, which is beyond the other limit, and a limit is rarely exact. A GUESS.
inline constexpr double beyond_range_rad = units::rad(20.0);

/// Whether a joint that turns against its stop has found it: it gets along by less than a share of what it would in the
/// time of the measurements, and pushes, where its current tells. One that stands and does not push may have started
/// afresh: it has the time to be told again and to get going before that passes for its stop. Pure; the caller turns
/// it.
class StopSearch
{
public:
    enum class Seen {
        way,     ///< it goes on
        stop,    ///< something is in its way
        too_far, ///< it has turned as far as it may, or has taken longer for that than one that gets along
    };

    /// So long it must get along by less than a share of its way before something is in it.
    static constexpr Duration stand_still = std::chrono::milliseconds{200};
    static constexpr double share_of_way = 0.3;
    static constexpr Duration gets_going = std::chrono::seconds{1};
    static_assert(gets_going > 2 * repetition);
    static constexpr double least_push_a = 0.05; ///< less is none: half a step of the coarsest reading (Nuri)
    /// In every reading for so long, and in three at least: one that stands free may read a step now and then.
    static constexpr Duration pushes_for = std::chrono::milliseconds{100};
    static_assert(pushes_for < (1.0 - share_of_way) * stand_still); // of all that it has been standing

    StopSearch() = default;
    /// Of a joint that begins here, with its home velocity.
    StopSearch(const config::Joint& joint, double from_rad, TimePoint begin);

    /// In the time of the measurements: one that is missing must not pass for a joint that does not get along.
    /// `current_a`: of the device, none where it is not known.
    Seen look(const actuator::Measured<double>& here, const actuator::Measured<double>& current_a, TimePoint now);
    /// Why it ends `too_far`.
    std::string says(const std::string& joint) const;

private:
    double velocity_rad_s_ = 0.0;
    double longest_rad_ = 0.0;
    double travelled_rad_ = 0.0;
    double from_rad_ = 0.0;
    TimePoint looked_at_{}; ///< at `from_rad_`
    TimePoint since_{};     ///< and from then on it must get along
    TimePoint until_{};
    TimePoint measured_at_{}; ///< the last time
    Duration gap_{};          ///< since the time before
    TimePoint idle_at_{};     ///< it did not push
    bool stood_idle_ = false; ///< without a push, once
};

} // namespace sinew::robot
