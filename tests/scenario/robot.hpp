#pragma once
#include "sinew/bus/bus.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/sim/simulator.hpp"

#include <array>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <string>

/// What the scenarios share: drivers against simulated devices over real buses, in virtual time.
namespace sinew::test {

/// A robot file with its simulator, a bus for each of its lines and a driver for each joint.
class Robot
{
public:
    explicit Robot(config::RobotFile file)
        : file_(std::move(file)), resolved_(*resolve(file_)), simulator_(*sim::Simulator::make(file_))
    {
        for (const auto& bus : file_.buses)
            buses_[bus.name] = std::make_unique<bus::Bus>(bus.name, *simulator_->open(bus.name), simulator_->clock(),
                                                          *find_family(bus.family.value)->protocol);
        for (const auto& joint : resolved_.joints) {
            buses_[joint.bus->name]->set_device(id_of(joint.device), {.line = &line_of(joint.device),
                                                                      .options = options_of(joint.device),
                                                                      .response_time = response_time_of(joint.device)});
            drivers_[joint.joint->name] = make_driver(joint.device);
        }
    }

    const ResolvedRobot& resolved() const { return resolved_; }
    actuator::Driver& driver(const std::string& joint) { return *drivers_[joint]; }
    sim::Simulator& simulator() { return *simulator_; }
    sim::Look look(const std::string& joint) { return *simulator_->world().look(joint); }
    bus::Bus& line(const std::string& name) { return *buses_[name]; }
    TimePoint now() { return simulator_->clock().now(); }
    const bus::Counters& weather(const std::string& bus) { return buses_[bus]->conversation().counters(); }

    actuator::State read(const ResolvedJoint& joint, actuator::Depth depth)
    {
        actuator::State state;
        run(joint, *driver(joint.joint->name).plan_read(depth), state);
        return state;
    }

    void command(const ResolvedJoint& joint, const actuator::Command& command, actuator::State state = {})
    {
        const auto plan = driver(joint.joint->name).plan(command, state);
        ASSERT_TRUE(plan.has_value()) << joint.joint->name << ": " << to_sentence(plan.error());
        run(joint, *plan, state);
    }

    /// One turn of a control loop; how many requests it took.
    std::size_t cycle(const ResolvedJoint& joint, const actuator::Command& command, actuator::State& state)
    {
        const auto plan = driver(joint.joint->name).plan_cycle(command, state);
        EXPECT_TRUE(plan.has_value()) << joint.joint->name << ": " << (plan ? "" : to_sentence(plan.error()));
        if (!plan)
            return 0;
        run(joint, *plan, state);
        return plan->all().size();
    }

    void set_up(const ResolvedJoint& joint)
    {
        actuator::State state;
        run(joint, *driver(joint.joint->name).plan_settings(), state);
    }
    /// What shows that the device has started afresh, after asking for it.
    std::string_view reset_of(const ResolvedJoint& joint)
    {
        actuator::State state;
        run(joint, *driver(joint.joint->name).plan_reset_check(), state);
        return driver(joint.joint->name).noticed_reset();
    }

    void wait(Duration duration)
    {
        const TimePoint until = simulator_->clock().now() + duration;
        while (simulator_->clock().now() < until)
            simulator_->clock().wait({}, until);
    }

    void run(const ResolvedJoint& joint, const wire::Requests& requests, actuator::State& state)
    {
        std::array<bus::Result, wire::Requests::capacity> results;
        bus::Bus& bus = *buses_[joint.bus->name];
        const auto all = requests.all();
        ASSERT_TRUE(bus.exchange(all, std::span(results).first(all.size())).has_value());
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto reply = results[i].reply();
            ASSERT_TRUE(reply.has_value()) << joint.joint->name << ": " << to_sentence(reply.error());
            if (all[i].answered) {
                const auto absorbed = driver(joint.joint->name).absorb(all[i], *reply, results[i].at, state);
                ASSERT_TRUE(absorbed.has_value()) << joint.joint->name << ": " << to_sentence(absorbed.error());
            }
        }
    }

private:
    config::RobotFile file_;
    ResolvedRobot resolved_;
    std::unique_ptr<sim::Simulator> simulator_;
    std::map<std::string, std::unique_ptr<bus::Bus>> buses_;
    std::map<std::string, std::unique_ptr<actuator::Driver>> drivers_;
};

inline config::RobotFile demo()
{
    auto file = config::read_robot_file("robots/demo.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

inline config::RobotFile robot_file(std::string_view text)
{
    auto file = config::parse_robot_file(text, "robot.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

} // namespace sinew::test
