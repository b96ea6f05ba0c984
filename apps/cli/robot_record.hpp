#pragma once
#include "apps/cli/session.hpp"
#include "sinew/record/recorder.hpp"
#include "sinew/robot/robot.hpp"

/// What a verb drives is recorded meanwhile: frames, states, and what joints are told.
namespace sinew::cli {

inline constexpr Option record_option{"--record", "FILE.mcap", "keep in a recording what joints are told and do"};

/// What the recordings of a robot and of a device have in common. Must outlive the buses, which show it their frames.
class DrivenRecord
{
public:
    std::expected<void, Error> finish();

protected:
    /// Whether the words ask for one: its path, which can be written then.
    static std::expected<std::optional<std::string>, Error> path_from(const Words& words);
    explicit DrivenRecord(std::string path) : path_(std::move(path)) {}

    /// Nothing can be pushed where it fails; `finish` says why. `robot_file` is kept in it; empty: none.
    record::Recorder* create(const link::Clock& clock, bool virtual_time, const std::string& robot_file);
    void add(bus::Bus& bus, const std::string& name, const Family& family);
    /// After the joints and buses were added.
    void begin();
    /// After every push: in virtual time nobody else writes.
    void pushed();
    record::Recorder* recorder() { return recorder_.get(); }

private:
    std::string path_;
    bool virtual_time_ = false;
    std::unique_ptr<record::Recorder> recorder_;
    std::expected<void, Error> good_;
};

class RobotRecord : public DrivenRecord
{
public:
    /// Nothing where the words do not ask for it.
    static std::expected<std::unique_ptr<RobotRecord>, Error> make(const Words& words);

    void watch(robot::Robot& robot, bool virtual_time);
    /// After every cycle.
    void look();

private:
    using DrivenRecord::DrivenRecord;

    robot::Robot* robot_ = nullptr;
    std::vector<record::Recorder::Joint> joints_;
};

/// Of one device, which tells it by itself what it is told and what it says (`Driven::record`).
class DeviceRecord : public DrivenRecord
{
public:
    /// Nothing where the words do not ask for it.
    static std::expected<std::unique_ptr<DeviceRecord>, Error> make(const Words& words);

    void watch(Session& session, Driven& driven);
    void told(const actuator::Command& command);
    void said(const Driven& driven);

private:
    using DrivenRecord::DrivenRecord;

    const link::Clock* clock_ = nullptr;
    record::Recorder::Joint joint_{};
};

/// Finishes the recording, and how the verb ends that was recorded: with an error of the recording where all else went
/// well; it is told beside what else went wrong. `record`: may be nullptr.
Outcome recorded(Outcome outcome, DrivenRecord* record);

} // namespace sinew::cli
