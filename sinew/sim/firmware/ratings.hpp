#pragma once
#include "sinew/family/families.hpp"
#include "sinew/sim/firmware/servo.hpp"
#include "sinew/sim/plant/plant.hpp"

/// What the plant of a device is made of: the ratings that a document prints, the rest from `family/assumed.hpp`.
namespace sinew::sim {

/// Voltage for which the ratings of a device hold, and at which it is supplied unless its options say otherwise.
double rated_voltage_v(const DeviceSpec& spec);
double supply_v(const DeviceSpec& spec);
/// Where its shaft stands at the first power-on.
double start_rad(const DeviceSpec& spec);

/// Motor, gearbox and friction that give stall torque, stall current and no-load speed of the ratings exactly, with no
/// load on the shaft.
PlantParameters plant_of(const DeviceSpec& spec);
/// What that plant can do at the voltage it is supplied with.
Rating rating_of(const DeviceSpec& spec);

} // namespace sinew::sim
