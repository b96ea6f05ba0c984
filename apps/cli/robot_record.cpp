#include "apps/cli/robot_record.hpp"

#include "apps/cli/bus_target.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "sinew/family/families.hpp"
#include "sinew/record/tap.hpp"
#include "sinew/record/topics.hpp"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<std::optional<std::string>, Error> DrivenRecord::path_from(const Words& words)
{
    auto path = words.text("--record");
    if (!path)
        return std::nullopt;
    if (std::filesystem::path(*path).extension() != ".mcap")
        return fail(Errc::bad_argument, fmt::format("'{}' must end with .mcap", *path));
    if (auto writable = check_writable(*path); !writable)
        return std::unexpected(writable.error());
    return path;
}

record::Recorder* DrivenRecord::create(const link::Clock& clock, bool virtual_time, const std::string& robot_file)
{
    virtual_time_ = virtual_time;
    const auto zero = virtual_time ? record::Time{} : record::time_of_day_zero(clock);
    auto recorder = record::Recorder::create(path_, {.zero = zero});
    if (!recorder) {
        good_ = std::unexpected(recorder.error());
        return nullptr;
    }
    recorder_ = std::move(*recorder);
    if (robot_file.empty())
        return recorder_.get();
    if (auto text = robot_text_at(robot_file))
        good_ = recorder_->attach(std::string(record::robot_attachment), "application/toml", std::move(*text));
    return recorder_.get();
}

void DrivenRecord::add(bus::Bus& bus, const std::string& name, const Family& family)
{
    const auto id = recorder_->add_bus(
        {.name = name, .family = std::string(family.name), .can = family.can, .bit_rate = bus.link_state().bit_rate});
    bus.set_tap([this, id](const bus::Tapped& tapped) { recorder_->frame(id, tapped); });
}

void DrivenRecord::begin()
{
    if (!virtual_time_)
        recorder_->run_in_thread();
}

void DrivenRecord::pushed()
{
    if (virtual_time_ && good_)
        good_ = recorder_->drain();
}

std::expected<void, Error> DrivenRecord::finish()
{
    if (!recorder_)
        return good_;
    const auto finished = recorder_->finish();
    return good_ ? finished : good_;
}

// ---- a robot ----

std::expected<std::unique_ptr<RobotRecord>, Error> RobotRecord::make(const Words& words)
{
    auto path = path_from(words);
    if (!path)
        return std::unexpected(path.error());
    return *path ? std::unique_ptr<RobotRecord>(new RobotRecord(std::move(**path))) : nullptr;
}

void RobotRecord::watch(robot::Robot& robot, bool virtual_time)
{
    robot_ = &robot;
    auto* recorder = create(robot.clock(), virtual_time, robot.file().path);
    if (recorder == nullptr)
        return;
    for (const auto& joint : robot.joints())
        joints_.push_back(recorder->add_joint({.name = joint.name(), .bus = joint.bus()}));
    for (std::size_t i = 0; i < robot.buses().size(); ++i) {
        const auto& known = robot.file().buses[i];
        if (const auto* family = find_family(known.family.value))
            add(*robot.buses()[i], known.name, *family);
    }
    begin();
}

void RobotRecord::look()
{
    if (recorder() == nullptr)
        return;
    const auto now = robot_->clock().now();
    for (std::size_t i = 0; i < joints_.size(); ++i) {
        recorder()->state(joints_[i], robot_->joints()[i].state());
        recorder()->command(joints_[i], now, robot_->joints()[i].command());
    }
    pushed();
}

// ---- a device ----

std::expected<std::unique_ptr<DeviceRecord>, Error> DeviceRecord::make(const Words& words)
{
    auto path = path_from(words);
    if (!path)
        return std::unexpected(path.error());
    return *path ? std::unique_ptr<DeviceRecord>(new DeviceRecord(std::move(**path))) : nullptr;
}

void DeviceRecord::watch(Session& session, Driven& driven)
{
    clock_ = &session.clock();
    const auto& device = driven.device;
    const auto* joint = device.joint;
    auto* recorder = create(*clock_, session.in_virtual_time(), joint != nullptr ? device.file->path : std::string());
    if (recorder == nullptr)
        return;
    const auto bus = joint != nullptr ? joint->bus.value : short_name(device.link);
    joint_ = recorder->add_joint({.name = device.name, .bus = bus});
    add(*driven.bus, bus, *device.family);
    begin();
    driven.record = this;
    said(driven);
}

void DeviceRecord::told(const actuator::Command& command)
{
    recorder()->command(joint_, clock_->now(), command);
    pushed();
}

void DeviceRecord::said(const Driven& driven)
{
    recorder()->state(
        joint_,
        mounting_of(driven.device.joint).to_joint(driven.state, driven.driver->capabilities().current_has_sign));
    pushed();
}

Outcome recorded(Outcome outcome, DrivenRecord* record)
{
    const auto kept = record != nullptr ? record->finish() : std::expected<void, Error>{};
    if (kept)
        return outcome;
    if (outcome && *outcome == exit_done)
        return std::unexpected(kept.error());
    fmt::print(stderr, "sinew: {}\n", to_sentence(kept.error()));
    return outcome;
}

} // namespace sinew::cli
