#pragma once
#include "sinew/actuator/driver.hpp"
#include "sinew/family/families.hpp"

#include <memory>

/// The list of drivers. Never included by the simulator: driver and simulated device are two readings of the manuals.
namespace sinew {

/// The driver of a device. It copies what it needs.
std::unique_ptr<actuator::Driver> make_driver(const DeviceSpec& device);

} // namespace sinew
