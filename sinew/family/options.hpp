#pragma once
#include "sinew/family/nuri/models.hpp"
#include "sinew/family/option.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/family/sam/models.hpp"

#include <span>

/// The keys of `[joint.NAME.profile_options]`, `[joint.NAME.sim]` and `[joint.NAME.runtime]`, family by family. A Nuri
/// has no run-time settings.
namespace sinew {

namespace sam {
std::span<const Option<Profile>> profile_options();
std::span<const Option<DeviceOptions>> device_options();
std::span<const Option<Runtime>> runtime_options();
} // namespace sam

namespace nuri {
std::span<const Option<Profile>> profile_options();
std::span<const Option<DeviceOptions>> device_options();
} // namespace nuri

namespace rmd {
std::span<const Option<Profile>> profile_options();
std::span<const Option<DeviceOptions>> device_options();
std::span<const Option<Runtime>> runtime_options();
} // namespace rmd

} // namespace sinew
