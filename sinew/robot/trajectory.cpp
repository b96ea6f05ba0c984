#include "sinew/robot/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sinew::robot {
namespace {

constexpr double longest_s = 1e9; ///< what nanoseconds in 64 bits can hold, with room

/// The last point on the way from a good one to a bad one that is still good, to the last bit.
template <class Good>
double last_good(double good, double bad, Good is_good)
{
    constexpr int most_steps = 300; // the bits of a double, and its powers of two down to any size that matters
    for (int step = 0; step < most_steps; ++step) {
        const double middle = good + (bad - good) / 2.0;
        if (middle == good || middle == bad)
            break;
        (is_good(middle) ? good : bad) = middle;
    }
    return good;
}

Duration rounded_up(double time_s)
{
    return Duration{static_cast<std::int64_t>(std::ceil(time_s * 1e9))};
}

bool above_zero(double value)
{
    return std::isfinite(value) && value > 0.0;
}

std::expected<void, Error> check(double from, double velocity, double target, const MotionLimits& limits)
{
    if (!std::isfinite(from) || !std::isfinite(velocity) || !std::isfinite(target))
        return fail(Errc::bad_argument, "a motion needs a start and a target that are finite numbers");
    if (!above_zero(limits.velocity_rad_s) || !above_zero(limits.acceleration_rad_s2) || !(limits.jerk_rad_s3 > 0.0))
        return fail(Errc::bad_argument, "the greatest velocity, acceleration and jerk of a motion must be above 0");
    return {};
}

} // namespace

std::expected<Trajectory, Error> Trajectory::plan(double from_rad, double from_velocity_rad_s, double target_rad,
                                                  const MotionLimits& limits)
{
    if (auto checked = check(from_rad, from_velocity_rad_s, target_rad, limits); !checked)
        return std::unexpected(std::move(checked.error()));
    Trajectory out;
    out.limits_ = limits;
    out.from_ = from_rad;
    out.target_ = target_rad;
    out.sign_ = (from_velocity_rad_s != 0.0 ? from_velocity_rad_s : target_rad - from_rad) < 0.0 ? -1.0 : 1.0;
    out.speed_ = std::abs(from_velocity_rad_s);
    out.way_ = out.sign_ * (target_rad - from_rad);
    out.stop_way_ = Ramp(out.speed_, 0.0, limits).distance_rad();
    const double peak = out.soonest_peak();
    out.soonest_s_ = out.time_s(peak);
    if (!(out.soonest_s_ < longest_s))
        return fail(Errc::bad_argument, "a motion within these limits would take more than 30 years");
    out.set_peak(peak, out.soonest_s_, limits);
    return out;
}

std::expected<Trajectory, Error> Trajectory::stop(double from_rad, double from_velocity_rad_s,
                                                  const MotionLimits& limits)
{
    auto out = plan(from_rad, from_velocity_rad_s, from_rad, limits);
    if (!out)
        return out;
    out->way_ = out->stop_way_;
    out->target_ = out->from_ + out->sign_ * out->way_;
    out->soonest_s_ = out->time_s(0.0);
    out->set_peak(0.0, out->soonest_s_, limits);
    return out;
}

double Trajectory::ramps_distance(double peak) const
{
    return Ramp(speed_, peak, limits_).distance_rad() + Ramp(peak, 0.0, limits_).distance_rad();
}

double Trajectory::time_s(double peak) const
{
    const double ramps = Ramp(speed_, peak, limits_).duration_s() + Ramp(peak, 0.0, limits_).duration_s();
    return peak == 0.0 ? ramps : ramps + std::max(0.0, (way_ - ramps_distance(peak)) / peak);
}

/// Whether the ramps alone do not go further than the target.
bool Trajectory::fits(double peak) const
{
    return peak < 0.0 ? ramps_distance(peak) >= way_ : ramps_distance(peak) <= way_;
}

/// The peak not above the speed of the start with which the ramps go furthest. Between 0 and that speed their way grows
/// and then shrinks again, to that of an immediate stop.
double Trajectory::widest_peak() const
{
    double low = 0.0, high = speed_;
    for (int step = 0; step < 100; ++step) {
        const double third = (high - low) / 3.0;
        if (ramps_distance(low + third) < ramps_distance(high - third))
            low += third;
        else
            high -= third;
    }
    return low;
}

double Trajectory::soonest_peak() const
{
    const double most = limits_.velocity_rad_s;
    const auto good = [this](double peak) { return fits(peak); };
    if (way_ == stop_way_)
        return 0.0;
    if (way_ < stop_way_)
        return fits(-most) ? -most : last_good(0.0, -most, good);
    if (fits(most))
        return most;
    return speed_ <= most ? last_good(speed_, most, good) : last_good(0.0, most, good);
}

Trajectory::Gap Trajectory::gap() const
{
    const bool forwards = way_ > stop_way_ && speed_ > 0.0;
    if (!forwards)
        return {};
    const double widest = widest_peak();
    const double top = soonest_peak();
    if (fits(widest) || top <= widest)
        return {};
    const auto good = [this](double peak) { return fits(peak); };
    return {.low = last_good(0.0, widest, good), .high = last_good(std::min(speed_, top), widest, good)};
}

/// Of a moving start. The longer, the nearer to 0 is the peak.
double Trajectory::peak_lasting(double duration_s) const
{
    if (way_ == stop_way_)
        return 0.0;
    const auto soon_enough = [&](double peak) { return time_s(peak) <= duration_s; };
    const Gap left_out = gap();
    if (left_out.low == left_out.high)
        return last_good(soonest_peak(), 0.0, soon_enough);
    if (duration_s <= time_s(left_out.high))
        return last_good(soonest_peak(), left_out.high, soon_enough);
    return last_good(left_out.low, 0.0, soon_enough);
}

void Trajectory::set_peak(double peak, double duration_s, const MotionLimits& limits)
{
    peak_ = peak;
    first_ = Ramp(speed_, peak, limits);
    last_ = Ramp(peak, 0.0, limits);
    cruise_s_ = std::max(0.0, duration_s - first_.duration_s() - last_.duration_s());
    duration_s_ = duration_s;
}

Duration Trajectory::duration() const
{
    return rounded_up(duration_s_);
}

Duration Trajectory::reachable(Duration at_least) const
{
    const Duration soonest = std::max(at_least, rounded_up(soonest_s_));
    const Gap left_out = gap();
    if (left_out.low == left_out.high)
        return soonest;
    const Duration before = Duration{static_cast<std::int64_t>(time_s(left_out.high) * 1e9)};
    return soonest <= before ? soonest : std::max(soonest, rounded_up(time_s(left_out.low)));
}

std::expected<Trajectory, Error> Trajectory::lasting(Duration duration) const
{
    if (const Duration next = reachable(duration); next != duration)
        return fail(Errc::out_of_range, fmt::format("this motion cannot take {:.6g} s; it can take {:.6g} s",
                                                    seconds(duration), seconds(next)));
    const double wanted_s = seconds(duration);
    Trajectory out = *this;
    if (speed_ > 0.0 || way_ == 0.0) {
        out.set_peak(peak_lasting(wanted_s), wanted_s, limits_);
        return out;
    }
    // From rest the whole motion is slowed down.
    const double speed = std::min(1.0, soonest_s_ / wanted_s);
    out.set_peak(soonest_peak() * speed, wanted_s, slowed(limits_, speed));
    return out;
}

Setpoint Trajectory::at(Duration since_start) const
{
    const double t_s = seconds(since_start);
    if (t_s >= duration_s_)
        return {.position_rad = target_};
    const auto turned = [&](double way, const Setpoint& of) {
        return Setpoint{from_ + sign_ * way, sign_ * of.velocity_rad_s, sign_ * of.acceleration_rad_s2};
    };
    if (t_s <= 0.0)
        return turned(0.0, {.velocity_rad_s = speed_});
    if (t_s < first_.duration_s()) {
        const Setpoint on_ramp = first_.at(t_s);
        return turned(on_ramp.position_rad, on_ramp);
    }
    const double cruised_s = t_s - first_.duration_s();
    if (cruised_s < cruise_s_)
        return turned(first_.distance_rad() + peak_ * cruised_s, {.velocity_rad_s = peak_});
    // Counted back from the target, so that it ends there exactly.
    const Setpoint on_ramp = last_.at(cruised_s - cruise_s_);
    return {target_ - sign_ * (last_.distance_rad() - on_ramp.position_rad), sign_ * on_ramp.velocity_rad_s,
            sign_ * on_ramp.acceleration_rad_s2};
}

} // namespace sinew::robot
