#include "sinew/sim/firmware/devices.hpp"

#include "sinew/sim/firmware/nuri_device.hpp"
#include "sinew/sim/firmware/rmd_device.hpp"
#include "sinew/sim/firmware/sam_device.hpp"

namespace sinew::sim {
namespace {

struct Maker {
    std::unique_ptr<Device> operator()(const sam::Spec& spec) const { return std::make_unique<SamDevice>(spec); }
    std::unique_ptr<Device> operator()(const nuri::Spec& spec) const { return std::make_unique<NuriDevice>(spec); }
    std::unique_ptr<Device> operator()(const rmd::Spec& spec) const { return std::make_unique<RmdDevice>(spec); }
};

} // namespace

std::unique_ptr<Device> make_device(const DeviceSpec& spec)
{
    return std::visit(Maker{}, spec);
}

} // namespace sinew::sim
