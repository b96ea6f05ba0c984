#include "sinew/family/broadcast.hpp"

#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/sam/messages.hpp"

namespace sinew {
namespace {

template <class M>
std::optional<ToAll> to_all(const Family& family, const M& message, actuator::Mode mode)
{
    auto request = wire::make_request(family.broadcast_id, message);
    if (!request)
        return std::nullopt;
    request->answered = false;
    return ToAll{*request, mode};
}

} // namespace

std::optional<ToAll> stop_of_all(const Family& family)
{
    if (family.name == "sam")
        return to_all(family, sam::QuickBrakeMode{}, actuator::Mode::brake);
    if (family.name == "nuri")
        return to_all(family, nuri::SetControlOnOff{.control = nuri::Control::off}, actuator::Mode::release);
    return std::nullopt;
}

} // namespace sinew
