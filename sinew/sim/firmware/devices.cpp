#include "sinew/sim/firmware/devices.hpp"

#include "sinew/sim/firmware/nuri_device.hpp"
#include "sinew/sim/firmware/rmd_device.hpp"
#include "sinew/sim/firmware/sam_device.hpp"

namespace sinew::sim {
namespace {

struct Maker {
    const PlantParameters& plant;

    std::unique_ptr<Device> operator()(const sam::Spec& spec) const { return std::make_unique<SamDevice>(spec, plant); }
    std::unique_ptr<Device> operator()(const nuri::Spec& spec) const
    {
        return std::make_unique<NuriDevice>(spec, plant);
    }
    std::unique_ptr<Device> operator()(const rmd::Spec& spec) const { return std::make_unique<RmdDevice>(spec, plant); }
};

} // namespace

std::unique_ptr<Device> make_device(const DeviceSpec& spec, const PlantParameters& plant)
{
    return std::visit(Maker{plant}, spec);
}

} // namespace sinew::sim
