#pragma once
#include <span>
#include <string>
#include <vector>

namespace sinew::cli {

/// What may stand in the place of the last word of a command line that begins with "sinew": verbs, options, joints,
/// buses, messages, families. Those that begin as it does; nothing where files may stand, and where nothing is known.
/// Reads the robot file that the line or the environment names; opens no link.
std::vector<std::string> candidates(std::span<const std::string> line);

} // namespace sinew::cli
