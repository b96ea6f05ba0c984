#pragma once
#include "sinew/config/robot_file.hpp"

#include <optional>

namespace sinew::cli {

/// Where `jog` sends a joint next. Pure; the caller has keys, time and measurements. It begins where the joint is: from
/// beyond a limit only inwards, at the speed of the keys as anywhere else.
class JogAim
{
public:
    /// `joint` nullptr: without limits.
    explicit JogAim(const config::Joint* joint) : joint_(joint) {}

    static constexpr double speed_factor = 1.5;
    /// By that factor, but no faster than the joint may turn.
    double faster_rad_s(double speed_rad_s) const;

    /// A step of `step_rad` in this direction (+1 or -1) from the one before, or from `here` where there is none. What
    /// does not follow is led on by no more than `ahead_rad`. Nothing: it is beyond a limit and would go further out.
    std::optional<double> step(double here_rad, int direction, double step_rad, double ahead_rad);
    /// The next step begins where the joint is then.
    void forget() { target_rad_.reset(); }

private:
    double low_rad() const;
    double high_rad() const;

    const config::Joint* joint_;
    std::optional<double> target_rad_;
};

} // namespace sinew::cli
