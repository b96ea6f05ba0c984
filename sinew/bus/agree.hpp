#pragma once
#include "sinew/wire/row.hpp"

namespace sinew::bus {

/// Whether two answers to the same read can both be true. What is no value must be equal; a value may have moved
/// between the two by 1/32 of what its field allows, at least by 1: a shaft turns and a voltage sags meanwhile, but not
/// far. A value of one or two bits must be equal.
bool agree(const wire::Side& side, const wire::Frame& first, const wire::Frame& second);

} // namespace sinew::bus
