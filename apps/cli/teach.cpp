#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/interrupt.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/robot_session.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"
#include "sinew/config/pose_edit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <iterator>
#include <sys/stat.h>

namespace sinew::cli {
namespace {

using robot::Joint;

constexpr Duration look = std::chrono::milliseconds(50);

/// Those that the words name; else those of the pose that is there; else all.
std::expected<std::vector<std::string>, Error> joints_from(const Words& words, const config::RobotFile& file)
{
    std::vector<std::string> names(words.all("--joint").begin(), words.all("--joint").end());
    std::vector<std::string_view> known;
    for (const config::Joint& joint : file.joints)
        known.emplace_back(joint.name);
    for (const std::string& name : names)
        if (file.find_joint(name) == nullptr)
            return fail(Errc::unknown_name,
                        fmt::format("{} has no joint '{}'{}", file.path, name, suggestion(name, known)));
    if (!names.empty())
        return names;
    if (const config::Pose* pose = file.find_pose(words.text("POSE").value_or("")))
        for (const config::JointTarget& target : pose->targets)
            names.push_back(file.joints[target.joint].name);
    else
        for (const config::Joint& joint : file.joints)
            names.push_back(joint.name);
    return names;
}

std::vector<Joint*> find(robot::Robot& robot, const std::vector<std::string>& names)
{
    std::vector<Joint*> out;
    for (const std::string& name : names)
        out.push_back(robot.find(name));
    return out;
}

std::expected<void, Error> set_all(const std::vector<Joint*>& joints, robot::Mode mode)
{
    std::expected<void, Error> first;
    for (Joint* joint : joints)
        if (auto set = joint->set({.mode = mode}); !set && first)
            first = std::move(set);
    return first;
}

std::string positions(const std::vector<Joint*>& joints)
{
    std::vector<std::string> all;
    for (const Joint* joint : joints)
        if (joint->state().position_rad)
            all.push_back(fmt::format("{} {:.1f}", joint->name(), units::deg(*joint->state().position_rad)));
    return fmt::format("Enter keeps this: {} deg", fmt::join(all, ", "));
}

/// Lets a person move the joints. Whether Enter was pressed.
std::expected<bool, Error> by_hand(robot::Robot& robot, const std::vector<Joint*>& joints)
{
    if (auto released = set_all(joints, robot::Mode::release); !released)
        return std::unexpected(released.error());
    Typed key = Typed::nothing;
    const auto ran = robot.run(look, [&](robot::Robot&) {
        for (Joint& joint : robot.joints())
            joint.renew();
        progress(positions(joints));
        key = interrupted() ? Typed::end : typed();
        if (key != Typed::nothing)
            robot.leave();
    });
    end_progress();
    if (!ran)
        return std::unexpected(ran.error());
    return key == Typed::enter;
}

std::expected<std::vector<config::NewTarget>, Error> measured(const std::vector<Joint*>& joints)
{
    std::vector<config::NewTarget> out;
    for (const Joint* joint : joints) {
        const auto& at = joint->state().position_rad;
        if (!at)
            return fail(Errc::timeout, fmt::format("{} did not tell its position; nothing was written", joint->name()));
        const auto beyond = [&](std::string_view what, double limit) {
            return fail(Errc::out_of_range,
                        fmt::format("{} is at {:.2f} deg, beyond its {} of {:g} deg; nothing was written",
                                    joint->name(), units::deg(*at), what, units::deg(limit)));
        };
        if (joint->file().position_min_rad && *at < *joint->file().position_min_rad)
            return beyond("position_min_deg", *joint->file().position_min_rad);
        if (joint->file().position_max_rad && *at > *joint->file().position_max_rad)
            return beyond("position_max_deg", *joint->file().position_max_rad);
        out.push_back({joint->name(), *at});
    }
    return out;
}

/// The file as it is now, which may have been edited meanwhile, and with its permissions.
std::expected<void, Error> write(const std::string& path, std::string_view pose,
                                 const std::vector<config::NewTarget>& targets)
{
    std::error_code unknown;
    const auto place = std::filesystem::canonical(path, unknown);
    std::ifstream stream{place, std::ios::binary};
    const std::string before{std::istreambuf_iterator<char>{stream}, {}};
    if (!stream.is_open() || stream.bad())
        return fail(Errc::bad_file, fmt::format("{} cannot be read any more, so the pose is not written", path));
    const auto after = config::with_pose(before, path, pose, targets);
    if (!after)
        return std::unexpected(after.error());
    auto file = NewFile::make(place);
    if (!file)
        return std::unexpected(file.error());
    struct stat status{};
    if (::stat(place.c_str(), &status) == 0)
        (void)::fchmod(file->fd(), status.st_mode & 07777);
    if (auto written = file->write(*after); !written)
        return written;
    return file->keep();
}

void show(const Words& words, const std::string& path, const std::string& pose,
          const std::vector<config::NewTarget>& targets)
{
    if (words.json()) {
        Json joints = Json::array();
        for (const auto& target : targets)
            joints.add(Json::object({{"name", target.joint}, {"position_rad", target.position_rad}}));
        print(Json::object({{"pose", pose}, {"file", path}, {"joints", joints}}));
        return;
    }
    Table table({"JOINT", "POSITION"});
    for (const auto& target : targets)
        table.add({target.joint, fmt::format("{:.2f} deg", units::deg(target.position_rad))});
    fmt::print("{}", table.text());
    fmt::print(stderr, "Pose {} is in {}.\n", pose, path);
}

/// What can be known before anything is let go.
std::expected<void, Error> check_name(const config::RobotFile& file, const std::string& pose,
                                      const std::vector<std::string>& names)
{
    std::vector<config::NewTarget> targets;
    for (const std::string& name : names)
        targets.push_back({name, file.find_joint(name)->position_min_rad.value_or(
                                     file.find_joint(name)->position_max_rad.value_or(0.0))});
    std::ifstream stream{file.path, std::ios::binary};
    const std::string text{std::istreambuf_iterator<char>{stream}, {}};
    const auto changed = config::with_pose(text, file.path, pose, targets);
    return changed ? std::expected<void, Error>{} : std::unexpected(changed.error());
}

Outcome teach(const Words& words, robot::Robot& robot, const std::vector<std::string>& names)
{
    const std::string pose = *words.text("POSE");
    const auto joints = find(robot, names);
    const auto kept = by_hand(robot, joints);
    if (!kept)
        return std::unexpected(kept.error());
    const bool was_interrupted = interrupted();
    clear_interrupt();
    if (!words.has("--limp") || !*kept) {
        auto held = set_all(joints, robot::Mode::hold);
        held = held ? robot.wait(look * 4, look) : held;
        if (!held)
            return std::unexpected(held.error());
    }
    if (!*kept) {
        fmt::print(stderr, "Nothing was written; the joints hold.\n");
        return was_interrupted ? exit_interrupted : exit_refused;
    }
    const auto targets = measured(joints);
    if (!targets)
        return std::unexpected(targets.error());
    if (auto written = write(robot.file().path, pose, *targets); !written)
        return std::unexpected(written.error());
    show(words, robot.file().path, pose, *targets);
    return exit_done;
}

Outcome run(const Words& words)
{
    auto file = robot_file(words);
    if (!file)
        return std::unexpected(file.error());
    const auto names = joints_from(words, *file);
    if (!names)
        return std::unexpected(names.error());
    if (auto fine = check_name(*file, *words.text("POSE"), *names); !fine)
        return std::unexpected(fine.error());
    const auto yes =
        words.has("--sim")
            ? std::expected<bool, Error>(true)
            : confirm(words, fmt::format("{} will lose their torque: hold what they carry", fmt::join(*names, ", ")));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    auto session = RobotSession::open(words, std::move(*file));
    if (!session)
        return std::unexpected(session.error());
    if (auto on = (*session)->robot().enable(); !on)
        return std::unexpected(on.error());
    auto outcome = teach(words, (*session)->robot(), *names);
    (*session)->tell_incidents();
    return outcome;
}

} // namespace

Verb teach_verb()
{
    return {.name = "teach",
            .says = "Let joints be moved by hand, and keep where they are as a pose of the robot file.",
            .arguments = {{"POSE", "the name of the pose; one that is there gets new angles"}},
            .options = with_robot_options(
                {{"--joint", "NAME", "only this one; without it those of the pose, or all for a new one", true},
                 {"--limp", "", "leave the joints without torque afterwards; else they hold"}}),
            .examples = {{"sinew teach ready --robot arm.toml", "move the arm, then press Enter"},
                         {"sinew teach closed --joint gripper --robot arm.toml", "one joint"}},
            .run = run,
            .more = "Only the lines of that pose in the robot file are changed. Ctrl-C writes nothing, and the joints "
                    "hold."};
}

} // namespace sinew::cli
