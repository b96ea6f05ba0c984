#include "apps/cli/robot_record.hpp"

#include "apps/cli/new_file.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "sinew/family/families.hpp"
#include "sinew/record/tap.hpp"
#include "sinew/record/topics.hpp"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<std::unique_ptr<RobotRecord>, Error> RobotRecord::make(const Words& words)
{
    const auto path = words.text("--record");
    if (!path)
        return nullptr;
    if (std::filesystem::path(*path).extension() != ".mcap")
        return fail(Errc::bad_argument, fmt::format("'{}' must end with .mcap", *path));
    if (auto writable = check_writable(*path); !writable)
        return std::unexpected(writable.error());
    auto out = std::make_unique<RobotRecord>();
    out->path_ = *path;
    out->virtual_time_ = words.has("--sim");
    return out;
}

void RobotRecord::watch(robot::Robot& robot)
{
    robot_ = &robot;
    const auto zero = virtual_time_ ? record::Time{} : record::time_of_day_zero(robot.clock());
    auto recorder = record::Recorder::create(path_, {.zero = zero});
    if (!recorder) {
        good_ = std::unexpected(recorder.error());
        return;
    }
    recorder_ = std::move(*recorder);
    if (auto text = robot_text_at(robot.file().path))
        good_ = recorder_->attach(std::string(record::robot_attachment), "application/toml", std::move(*text));
    for (const auto& joint : robot.joints())
        joints_.push_back(recorder_->add_joint({.name = joint.name(), .bus = joint.bus()}));
    for (std::size_t i = 0; i < robot.buses().size(); ++i) {
        bus::Bus* bus = robot.buses()[i];
        const auto& known = robot.file().buses[i];
        const auto* family = find_family(known.family.value);
        const auto id = recorder_->add_bus({.name = known.name,
                                            .family = known.family.value,
                                            .can = family != nullptr && family->can,
                                            .bit_rate = bus->link_state().bit_rate});
        bus->set_tap([this, id](const bus::Tapped& tapped) { recorder_->frame(id, tapped); });
    }
    if (!virtual_time_)
        recorder_->run_in_thread();
}

void RobotRecord::look()
{
    if (!recorder_)
        return;
    const auto now = robot_->clock().now();
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        recorder_->state(joints_[i], robot_->joints()[i].state());
        recorder_->command(joints_[i], now, robot_->joints()[i].command());
    }
    if (virtual_time_ && good_)
        good_ = recorder_->drain();
}

std::expected<void, Error> RobotRecord::finish()
{
    if (!recorder_)
        return good_;
    const auto finished = recorder_->finish();
    return good_ ? finished : good_;
}

} // namespace sinew::cli
