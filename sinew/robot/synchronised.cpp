#include "sinew/robot/synchronised.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::robot {
namespace {

std::unexpected<Error> of_joint(std::size_t index, Error error)
{
    error.value = static_cast<std::int64_t>(index);
    return std::unexpected(std::move(error));
}

/// A duration that every joint can have. A joint leaves out one stretch of time at most, so each joint can move it on
/// only once.
Duration common(std::span<const Trajectory> all, Duration at_least)
{
    Duration out = at_least;
    for (std::size_t settled = 0, i = 0; settled < all.size(); ++settled, i = (i + 1) % all.size()) {
        const Duration next = all[i].reachable(out);
        if (next != out)
            settled = 0;
        out = next;
    }
    return out;
}

} // namespace

void Synchronised::reserve(std::size_t joints)
{
    all_.reserve(joints);
    next_.reserve(joints);
}

std::expected<void, Error> Synchronised::plan(std::span<const JointMotion> joints, std::optional<Duration> duration)
{
    next_.clear();
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const JointMotion& of = joints[i];
        auto soonest = Trajectory::plan(of.from_rad, of.from_velocity_rad_s, of.target_rad, of.limits);
        if (!soonest)
            return of_joint(i, std::move(soonest.error()));
        next_.push_back(*soonest);
    }
    const Duration together = common(next_, duration.value_or(Duration{}));
    for (std::size_t i = 0; i < next_.size(); ++i) {
        auto one = next_[i].lasting(duration.value_or(together));
        if (!one)
            return of_joint(i, std::move(one.error()));
        next_[i] = *one;
    }
    std::swap(all_, next_);
    duration_ = duration.value_or(together);
    return {};
}

} // namespace sinew::robot
