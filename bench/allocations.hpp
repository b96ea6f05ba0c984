#pragma once
#include <cstdint>

namespace sinew::bench {

/// How often this program has asked the heap for memory so far.
std::uint64_t allocations();

} // namespace sinew::bench
