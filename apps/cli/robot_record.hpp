#pragma once
#include "apps/cli/verb.hpp"
#include "sinew/record/recorder.hpp"
#include "sinew/robot/robot.hpp"

/// A whole robot that is recorded while a verb drives it: frames, states, and what its joints are told.
namespace sinew::cli {

inline constexpr Option record_option{"--record", "FILE.mcap", "keep in a recording what joints are told and do"};

class RobotRecord
{
public:
    /// Nothing where the words do not ask for it. Must outlive the robot, whose buses show it their frames.
    static std::expected<std::unique_ptr<RobotRecord>, Error> make(const Words& words);

    void watch(robot::Robot& robot);
    /// After every cycle.
    void look();
    std::expected<void, Error> finish();

private:
    robot::Robot* robot_ = nullptr;
    std::string path_;
    bool virtual_time_ = false;
    std::unique_ptr<record::Recorder> recorder_;
    std::vector<record::Recorder::Joint> joints_;
    std::expected<void, Error> good_;
};

} // namespace sinew::cli
