#include "sinew/config/pose_edit.hpp"
#include "sinew/family/families.hpp"
#include "sinew/robot/sequence.hpp"
#include "tests/fuzz/check.hpp"

#include <cmath>

namespace {

/// Plays for a while with joints that are wherever they are told to be.
void play(const sinew::config::RobotFile& file, const sinew::config::Sequence& sequence)
{
    sinew::TimePoint now{};
    std::vector<sinew::actuator::State> states(file.joints.size());
    for (auto& state : states)
        state.position_rad = {0.0, now};
    sinew::robot::SequencePlayer player(file, sequence);
    auto status = sinew::robot::SequencePlayer::Status::running;
    for (int call = 0; call < 200 && status == sinew::robot::SequencePlayer::Status::running; ++call) {
        status = player.next(now, states);
        now += std::chrono::milliseconds(40);
        for (std::size_t i = 0; i < states.size(); ++i)
            if (const auto& target = player.targets()[i]) {
                SINEW_CLAIM(std::isfinite(target->position_rad) && std::isfinite(target->velocity_rad_s));
                states[i].position_rad = {target->position_rad, now};
            }
    }
    if (status == sinew::robot::SequencePlayer::Status::failed)
        SINEW_CLAIM(!to_sentence(player.error()).empty());
}

/// A pose of it gets another angle, or a new one comes: then it can be read and has it.
void teach(std::string_view text, const sinew::config::RobotFile& file)
{
    if (file.joints.empty())
        return;
    const auto& joint = file.joints.front();
    const std::string pose = file.poses.empty() ? "taught" : file.poses.front().name;
    const sinew::config::NewTarget target{joint.name, joint.position_min_rad.value_or(0.0)};
    const auto changed = sinew::config::with_pose(text, "robot.toml", pose, {&target, 1});
    if (!changed)
        SINEW_CLAIM(!to_sentence(changed.error()).empty());
    else
        SINEW_CLAIM(sinew::config::parse_robot_file(*changed, "robot.toml")->find_pose(pose) != nullptr);
}

} // namespace

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
    for (const auto& pose : file->poses)
        for (const auto& target : pose.targets) {
            SINEW_CLAIM(target.joint < file->joints.size());
            const auto& joint = file->joints[target.joint];
            SINEW_CLAIM(!joint.position_min_rad || target.position_rad >= *joint.position_min_rad);
            SINEW_CLAIM(!joint.position_max_rad || target.position_rad <= *joint.position_max_rad);
        }
    for (const auto& sequence : file->sequences)
        play(*file, sequence);
    teach(text, *file);
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
