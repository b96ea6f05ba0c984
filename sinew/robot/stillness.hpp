#pragma once
#include "sinew/actuator/measured.hpp"
#include "sinew/base/units.hpp"

namespace sinew::robot {

/// Slower than this a joint is at rest; faster, it is on its way or creeps.
inline constexpr double rest_rad_s = units::rad(1.0);

/// A velocity that is so much older than a position may be another one by now.
inline constexpr Duration old_velocity = std::chrono::milliseconds{30};

/// So long whoever was told to hold is looked at until it stands still.
inline constexpr Duration longest_rest = std::chrono::seconds{2};
/// And at least so long again once it was let go of what it pressed on, and holds anew (`pressing.hpp`).
inline constexpr Duration rest_after_relief = std::chrono::milliseconds{500};

/// Whether a joint stands still, by where it was measured: the one place that says when it is at rest. A position is
/// known to one step, so it may be a step further from another one than it looks; a joint is at rest when even so it
/// was slower than `rest_rad_s` since the first of these looks. A coarse position that flickers by a step takes the
/// longer to tell. Pure; joint units.
class Stillness
{
public:
    /// In so long, and so many looks, at least: at two of them it may be where it turns round.
    static constexpr Duration least = std::chrono::milliseconds{100};
    static constexpr int fewest_looks = 3;

    Stillness() = default;
    /// `step_rad`: what one step of its position is, at the finest.
    explicit Stillness(double step_rad) : step_rad_(step_rad) {}

    /// From now on. Nothing that was seen before counts.
    void begin()
    {
        first_ = last_ = {};
        looks_ = 0;
    }
    /// A look; one that measured nothing new tells nothing.
    void look(const actuator::Measured<double>& here);
    bool is_at_rest() const;

private:
    double most_rad() const;

    double step_rad_ = 0.0;
    actuator::Measured<double> first_, last_;
    int looks_ = 0;                         ///< since `first_`
    double low_rad_ = 0.0, high_rad_ = 0.0; ///< between which it was seen since `first_`
};

} // namespace sinew::robot
