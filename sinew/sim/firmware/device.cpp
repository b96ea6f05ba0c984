#include "sinew/sim/firmware/device.hpp"

#include <algorithm>

namespace sinew::sim {

void Device::run(double supply_v)
{
    supply_v_ = is_plugged_ ? std::min(supply_v, supply_most_v_) : 0.0;
    const bool enough = supply_v_ >= runs_above_v;
    if (enough && !is_on_)
        power_on();
    is_on_ = enough;
    if (is_on_)
        control();
    else
        plant_.open();
    plant_.run(supply_v_);
}

void Device::power_cycle()
{
    if (is_on_)
        power_on();
}

Look Device::look() const
{
    Look look{.position_rad = plant_.position_rad(),
              .velocity_rad_s = plant_.velocity_rad_s(),
              .mode = "off",
              .current_a = plant_.current_a(),
              .voltage_v = supply_v_,
              .temperature_c = plant_.case_c()};
    if (is_on_)
        tell(look);
    return look;
}

} // namespace sinew::sim
