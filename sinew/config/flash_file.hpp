#pragma once
#include "sinew/config/robot_file.hpp"

/// What the devices of a simulated robot keep without power, as a file:
///
///     version = 1
///     [joint.elbow]
///     family = "sam"
///     writes = 3
///     p_gain = 100
///
/// The values are whole numbers that the simulated device of the joint knows by name.
namespace sinew::config {

struct FlashJoint {
    std::string name;
    Mark at;
    Marked<std::string> family;
    std::vector<Setting> values;
};

struct FlashFile {
    std::string path; ///< as given, for messages
    std::vector<FlashJoint> joints;
};

/// `bad_file` with "FILE:LINE:COLUMN: what is wrong and what would be right".
std::expected<FlashFile, Error> parse_flash_file(std::string_view text, std::string path);

std::expected<FlashFile, Error> read_flash_file(const std::filesystem::path& path);

/// A `bad_file` error at a place of this file.
std::unexpected<Error> fail_at(const FlashFile& file, Mark at, std::string what);

} // namespace sinew::config
