#pragma once
#include "sinew/link/link.hpp"

#include <functional>

namespace sinew::link {

/// One try to open a link again: it opens, or says why not, without waiting for a device or a host that is not there.
/// Called again and again by whoever lost its link; `Links::reopener` makes one.
using Reopen = std::function<std::expected<AnyLink, Error>()>;

} // namespace sinew::link
