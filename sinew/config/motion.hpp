#pragma once
#include "sinew/config/mark.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// Poses and sequences of a robot file, checked against its joints (docs/guide/sequences.md). Plain values.
namespace sinew::config {

struct JointTarget {
    std::size_t joint = 0; ///< of `RobotFile::joints`
    double position_rad = 0.0;
    Mark at;
};

/// `[pose.NAME]`: where some joints are, in the order of the file.
struct Pose {
    std::string name;
    Mark at;
    std::vector<JointTarget> targets;
};

/// What a step waits for.
struct Condition {
    enum class Of : std::uint8_t {
        position, ///< as measured
        speed,    ///< the size of the velocity
        current,  ///< its size
    };
    std::size_t joint = 0;
    Of of = Of::position;
    bool above = false; ///< else below
    double value = 0.0; ///< rad, rad/s or A
    double within_s = 0.0;
    bool goes_on = false; ///< after a time-out; else it is the end of the sequence
    Mark at;
};

/// One step of a sequence. What belongs to which kind is said beside it.
struct Step {
    enum class Kind : std::uint8_t {
        move,   ///< `targets`, `duration_s` or `speed`, `until`
        wait,   ///< `duration_s`
        until,  ///< `until`
        repeat, ///< `times`, `steps`
        call,   ///< `times`, `sequence`
    };
    Kind kind = Kind::wait;
    Mark at;
    Marked<std::string> name; ///< of the pose or the sequence; empty: of none
    std::vector<JointTarget> targets;
    std::optional<double> duration_s;
    double speed = 1.0; ///< of the fastest, above 0 up to 1
    std::optional<Condition> until;
    std::optional<std::int64_t> times = 1; ///< nothing: for ever
    std::vector<Step> steps;
    std::size_t sequence = 0; ///< of `RobotFile::sequences`
};

/// `[sequence.NAME]`. Calls never lead back to where they began, and with its repetitions and calls a sequence is
/// `deepest_nesting` deep at most.
struct Sequence {
    std::string name;
    Mark at;
    std::vector<Step> steps;
};

inline constexpr std::size_t deepest_nesting = 16;

} // namespace sinew::config
