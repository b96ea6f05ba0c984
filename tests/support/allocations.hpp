#pragma once
#include <cstdint>

namespace sinew::support {

/// How often this program has asked the heap for memory so far.
std::uint64_t allocations();

} // namespace sinew::support
