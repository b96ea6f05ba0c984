#include "sinew/family/drivers.hpp"

#include "sinew/family/nuri/driver.hpp"
#include "sinew/family/rmd/driver.hpp"
#include "sinew/family/sam/driver.hpp"

namespace sinew {

std::unique_ptr<actuator::Driver> make_driver(const DeviceSpec& device)
{
    struct Make {
        std::unique_ptr<actuator::Driver> operator()(const sam::Spec& s) const
        {
            return std::make_unique<sam::Driver>(s);
        }
        std::unique_ptr<actuator::Driver> operator()(const nuri::Spec& s) const
        {
            return std::make_unique<nuri::Driver>(s);
        }
        std::unique_ptr<actuator::Driver> operator()(const rmd::Spec& s) const
        {
            return std::make_unique<rmd::Driver>(s);
        }
    };
    return std::visit(Make{}, device);
}

} // namespace sinew
