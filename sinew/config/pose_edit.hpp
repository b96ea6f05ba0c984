#pragma once
#include "sinew/config/robot_file.hpp"

#include <span>

namespace sinew::config {

struct NewTarget {
    std::string joint;
    double position_rad = 0.0;
};

/// The text of a robot file with these joints in `[pose.NAME]`, and everything else as it was, comments too. A pose
/// that is there keeps its other joints, the order of its lines and the unit of each; what is new comes at its end, in
/// degrees; a new pose comes at the end of the file. Angles are rounded to a thousandth of a degree.
///
/// `path` is for messages. `bad_file` when the text is no robot file before or after that, a position beyond the limits
/// of its joint included; `bad_argument` for a name that cannot be one, that of a sequence, and a pose that is there
/// but not as a table of its own.
std::expected<std::string, Error> with_pose(std::string_view text, const std::string& path, std::string_view pose,
                                            std::span<const NewTarget> targets);

} // namespace sinew::config
