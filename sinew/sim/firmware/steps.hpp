#pragma once
#include "sinew/sim/plant/plant.hpp"

#include <optional>

namespace sinew::sim {

/// Turns time into whole steps of a plant. The first time it is told is where it begins.
class Steps
{
public:
    /// The steps that lie between the last one and `now`.
    std::int64_t due(TimePoint now)
    {
        if (!last_)
            last_ = now;
        const std::int64_t steps = (now - *last_) / plant_step;
        *last_ += steps * plant_step;
        return steps;
    }

private:
    std::optional<TimePoint> last_;
};

} // namespace sinew::sim
