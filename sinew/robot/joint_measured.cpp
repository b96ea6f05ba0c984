#include "sinew/base/units.hpp"
#include "sinew/robot/joint.hpp"
#include "sinew/robot/rules.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

/// What a joint believes of what its device answers.
namespace sinew::robot {
namespace {

/// What a shaft may jump by at most for the time between two answers, beside what it turns.
constexpr double doubtful_way_rad = units::rad(2.0);
constexpr double leap_in_velocities = 1.5;
constexpr Duration longest_memory = std::chrono::milliseconds{20};
constexpr int answers_to_believe = 3;
/// Looks at a joint of a slow bus: one is missing, and the next comes late.
constexpr int lost_without_doubt = 2;

} // namespace

/// Answers without a checksum (SAM) may say anything. A shaft that would have come there faster than it can turn, or of
/// which nothing was known, is believed when enough answers in a row say the same. `before`: the position so far.
bool Joint::is_plausible(const actuator::Measured<double>& before)
{
    const auto& fastest = driver_->capabilities().velocity_max_rad_s;
    const auto& said = raw_.position_rad;
    if (!fastest || !said || (before && said.at() == before.at()) || !family().protocol->bare_replies())
        return true;
    const auto follows = [&](const actuator::Measured<double>& earlier) {
        const Duration gap = std::chrono::abs(said.at() - earlier.at());
        const double way = 1.5 * *fastest * seconds(std::min(gap, longest_memory));
        return earlier && std::abs(*said - *earlier) <= way + doubtful_way_rad;
    };
    if (follows(before)) {
        agreed_ = 0;
        return true;
    }
    agreed_ = follows(suspect_) ? agreed_ + 1 : 1;
    suspect_ = said;
    if (agreed_ < answers_to_believe)
        return false;
    agreed_ = 0;
    return true;
}

/// A shaft that would have turned further than the joint may counts from elsewhere, if the next answer says that it
/// stands there or turns no faster than it may. One answer alone may have been garbled and pass its checksum all the
/// same; two in a row are never refused, for a shaft may really turn too fast. A hand may turn what was let go.
bool Joint::is_no_leap(const actuator::Measured<double>& before)
{
    const auto& fastest = limits().velocity_max_rad_s;
    const auto& said = raw_.position_rad;
    if (!counts_from_power_on() || lets_go(command_) || !fastest || !before || !said || said.at() <= before.at())
        return true;
    const auto follows = [&](const actuator::Measured<double>& earlier) {
        const double way = leap_in_velocities * *fastest * mounting_.ratio * seconds(said.at() - earlier.at());
        return std::abs(*said - *earlier) <= way + doubtful_way_rad;
    };
    const auto suspect = std::exchange(suspect_, {});
    if (follows(before))
        return true;
    if (suspect)
        leapt_ = leapt_ || follows(suspect);
    else
        suspect_ = said;
    return suspect.has_value();
}

Duration Joint::usual_silence() const
{
    return std::max<Duration>(doubtful_silence, lost_without_doubt * interval_);
}

bool Joint::is_silent() const
{
    return missing_since_ && is_doubtful(now() - *missing_since_);
}

void Joint::absorb(const wire::Request& asked, const wire::Frame& reply, TimePoint at)
{
    const auto before = raw_.position_rad;
    if (const auto absorbed = driver_->absorb(asked, reply, at, raw_); !absorbed)
        return failed(absorbed.error(), at, &asked);
    if (!is_plausible(before) || !is_no_leap(before)) {
        raw_.position_rad = before;
        if (before)
            return; // and it counts as no answer
    }
    answered_at_ = std::max(answered_at_, at);
    if (missing_since_ && is_doubtful(at - *missing_since_))
        silence_ = {.since = *missing_since_, .lasted = at - *missing_since_};
    missing_since_.reset();
    cut_since_.reset();
}

} // namespace sinew::robot
