#include "sinew/sim/firmware/sam_protection.hpp"

#include "sinew/family/sam/models.hpp"
#include "sinew/sim/plant/plant.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

constexpr Duration set_time = 200ms;     // L253, L448
constexpr Duration set_passive = 300ms;  // L448: at least
constexpr Duration blue_time = 300ms;    // L253
constexpr Duration fixed_time = 1s;      // L255
constexpr Duration fixed_passive = 5s;   // L255
constexpr Duration blink_period = 500ms; // ASSUMED: the red LED blinks (L716), no more is said

} // namespace

bool SamProtection::control(double current_a, double temperature_c, bool is_driving, Limits limits)
{
    passive_left_ = std::max(Duration{}, passive_left_ - tick);
    blue_left_ = std::max(Duration{}, blue_left_ - tick);
    is_hot_ = temperature_c >= sam::overheat_c || (is_hot_ && temperature_c > sam::overheat_c - limits.hysteresis_k);
    hot_for_ = is_hot_ ? (hot_for_ + tick) % blink_period : Duration{};

    const double current = is_driving && !is_passive() ? std::abs(current_a) : 0.0;
    over_set_ = current > limits.overload_a ? over_set_ + tick : Duration{};
    over_fixed_ = limits.fixed_a > 0.0 && current > limits.fixed_a ? over_fixed_ + tick : Duration{};
    if (over_fixed_ > fixed_time)
        let_go(fixed_passive);
    else if (over_set_ > set_time)
        let_go(set_passive);
    else
        return false;
    return true;
}

void SamProtection::let_go(Duration passive)
{
    passive_left_ = passive;
    blue_left_ = blue_time;
    over_set_ = over_fixed_ = Duration{};
}

bool SamProtection::red_led() const
{
    return is_hot_ && hot_for_ < blink_period / 2;
}

std::string_view SamProtection::faults() const
{
    if (is_hot_)
        return is_passive() ? "hot, overload" : "hot";
    return is_passive() ? "overload" : "";
}

} // namespace sinew::sim
