#pragma once
#include "sinew/base/time.hpp"

namespace sinew {

/// The other way round than `seconds`, towards zero. What is no number, or lies beyond 292 years, is no duration: the
/// caller has seen to that.
constexpr Duration from_seconds(double s)
{
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
}

} // namespace sinew
