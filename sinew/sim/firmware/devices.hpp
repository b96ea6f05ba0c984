#pragma once
#include "sinew/family/families.hpp"
#include "sinew/sim/firmware/device.hpp"

#include "sinew/sim/plant/plant.hpp"

#include <memory>

namespace sinew::sim {

/// The device that `spec` describes, not yet supplied, with the settings and the position that `spec` gives it.
std::unique_ptr<Device> make_device(const DeviceSpec& spec, const PlantParameters& plant);

} // namespace sinew::sim
