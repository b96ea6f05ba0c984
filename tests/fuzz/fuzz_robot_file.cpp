#include "sinew/config/robot_file.hpp"
#include "sinew/family/families.hpp"
#include "tests/fuzz/check.hpp"

/// Any text as a robot file, read and worked out.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto file = sinew::config::parse_robot_file(text, "robot.toml");
    if (!file) {
        SINEW_CLAIM(file.error().code == sinew::Errc::bad_file);
        SINEW_CLAIM(!to_sentence(file.error()).empty());
        return 0;
    }
    const auto robot = sinew::resolve(*file);
    if (!robot) {
        SINEW_CLAIM(!to_sentence(robot.error()).empty());
        return 0;
    }
    SINEW_CLAIM(robot->joints.size() == file->joints.size());
    for (const auto& joint : robot->joints) {
        SINEW_CLAIM(joint.joint != nullptr && joint.bus != nullptr && joint.family != nullptr);
        SINEW_CLAIM(joint.family->ids.contains(sinew::id_of(joint.device)));
    }
    return 0;
}
