#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/family/families.hpp"
#include "sinew/wire/request.hpp"

#include <optional>

namespace sinew {

/// One request to all devices of a line, which nobody answers, and what it makes them do.
struct ToAll {
    wire::Request request;
    actuator::Mode mode{};
};

/// The stop that a family has for all devices of a line at once: a SAM brakes, a Nuri is released. Nothing: it has
/// none.
std::optional<ToAll> stop_of_all(const Family& family);

} // namespace sinew
