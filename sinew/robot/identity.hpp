#pragma once
#include "sinew/family/families.hpp"
#include "sinew/wire/request.hpp"

#include <string_view>

/// What a device says that it is: with a wrong model every scale is wrong, and so is where it goes.
namespace sinew::robot {

/// The request by which a device says it; none where it does not.
std::expected<wire::Requests, Error> plan_identity(const DeviceSpec& device);

/// What it answered against what `source` (such as "the robot file") says of it: `bad_reply` with both.
std::expected<void, Error> compare_identity(std::string_view joint, std::string_view source, const DeviceSpec& device,
                                            const wire::Request& asked, const wire::Frame& reply);

} // namespace sinew::robot
