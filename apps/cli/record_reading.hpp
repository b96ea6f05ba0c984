#pragma once
#include "apps/cli/joint.hpp"

namespace sinew::cli {

/// Reads all that the words name, every bus at its own rate, and records it with its frames until `time` is over or
/// Ctrl-C; then prints what there is. Nothing is sent but reads.
Outcome record_reading(const Words& words, const std::string& path, std::optional<Duration> time);

} // namespace sinew::cli
