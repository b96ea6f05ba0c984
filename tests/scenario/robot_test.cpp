#include "sinew/base/units.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/family/drivers.hpp"
#include "sinew/sim/simulator.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

namespace sinew {
namespace {

using namespace std::chrono_literals;
using actuator::Depth;
using actuator::Mode;

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
    const bus::Counters& weather(const std::string& bus) { return buses_[bus]->conversation().counters(); }

    actuator::State read(const ResolvedJoint& joint, Depth depth)
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

    void wait(Duration duration)
    {
        const TimePoint until = simulator_->clock().now() + duration;
        while (simulator_->clock().now() < until)
            simulator_->clock().wait({}, until);
    }

private:
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

    config::RobotFile file_;
    ResolvedRobot resolved_;
    std::unique_ptr<sim::Simulator> simulator_;
    std::map<std::string, std::unique_ptr<bus::Bus>> buses_;
    std::map<std::string, std::unique_ptr<actuator::Driver>> drivers_;
};

config::RobotFile demo()
{
    auto file = config::read_robot_file("robots/demo.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

config::RobotFile robot(std::string_view text)
{
    auto file = config::parse_robot_file(text, "robot.toml");
    EXPECT_TRUE(file.has_value()) << (file ? "" : to_sentence(file.error()));
    return *file;
}

/// What the driver reads against what the shaft does; one unit of the protocol apart at most.
void expect_agreement(Robot& robot, const ResolvedJoint& joint)
{
    const auto state = robot.read(joint, Depth::full);
    const double step = robot.driver(joint.joint->name).capabilities().position_step_rad;
    EXPECT_NEAR(*state.position_rad, robot.look(joint.joint->name).position_rad, step) << joint.joint->name;
}

TEST(Scenario, EveryJointOfTheDemoGoesWhereItIsSent)
{
    Robot robot(demo());
    ASSERT_EQ(robot.resolved().joints.size(), 16U);
    for (const auto& joint : robot.resolved().joints) {
        const auto& can = robot.driver(joint.joint->name).capabilities();
        const auto before = robot.read(joint, Depth::full);
        const double target = *before.position_rad + units::rad(20);
        actuator::Command go{.mode = Mode::position, .position_rad = target};
        if (can.velocity_limit)
            go.velocity_rad_s = units::rad(60);
        robot.command(joint, go, before);
        robot.wait(1s);
        EXPECT_NEAR(robot.look(joint.joint->name).position_rad, target, can.position_step_rad) << joint.joint->name;
        expect_agreement(robot, joint);
    }
    for (const auto* bus : {"left", "waist", "legs"})
        EXPECT_EQ(robot.weather(bus).timeouts + robot.weather(bus).strays, 0U) << bus;
}

TEST(Scenario, AMoveWithASpeedTakesTheTimeThatTheSpeedAsksFor)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints) {
        if (!robot.driver(joint.joint->name).capabilities().velocity_limit)
            continue;
        const auto before = robot.read(joint, Depth::full);
        robot.command(joint,
                      {.mode = Mode::position,
                       .position_rad = *before.position_rad + units::rad(90),
                       .velocity_rad_s = units::rad(30)},
                      before);
        robot.wait(1500ms);
        // Half of the way in half of the time; the ramp at the start costs less than a degree.
        const double way = units::deg(robot.look(joint.joint->name).position_rad - *before.position_rad);
        EXPECT_GT(way, 44.0) << joint.joint->name;
        EXPECT_LE(way, 45.1) << joint.joint->name << ": never faster than asked";
    }
}

TEST(Scenario, EveryJointTurnsInTheSenseOfItsVelocityAndHolds)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints)
        for (const double sense : {1.0, -1.0}) {
            robot.command(joint, {.mode = Mode::velocity, .velocity_rad_s = sense * units::rad(60)},
                          robot.read(joint, Depth::full));
            robot.wait(1500ms);
            const auto state = robot.read(joint, Depth::full);
            EXPECT_GT(sense * robot.look(joint.joint->name).velocity_rad_s, 0.0) << joint.joint->name;
            ASSERT_TRUE(state.velocity_rad_s.has_value()) << joint.joint->name;
            EXPECT_GT(sense * *state.velocity_rad_s, 0.0) << joint.joint->name;
            robot.command(joint, {.mode = Mode::hold}, state);
            robot.wait(2s);
            EXPECT_NEAR(robot.look(joint.joint->name).velocity_rad_s, 0.0, 1e-9) << joint.joint->name;
        }
}

TEST(Scenario, ReleasedJointsHaveNoDriveAndComeBack)
{
    Robot robot(demo());
    for (const auto& joint : robot.resolved().joints) {
        robot.command(joint, {.mode = Mode::release}, robot.read(joint, Depth::full));
        const auto mode = std::string(robot.look(joint.joint->name).mode);
        EXPECT_TRUE(mode == "passive" || mode == "off") << joint.joint->name << " is " << mode;
        const auto before = robot.read(joint, Depth::full);
        robot.command(joint, {.mode = Mode::position, .position_rad = *before.position_rad + 0.2}, before);
        robot.wait(2s);
        EXPECT_NEAR(robot.look(joint.joint->name).position_rad, *before.position_rad + 0.2, 0.02) << joint.joint->name;
    }
}

TEST(Scenario, AProfileThatNobodyNamedCanOnlyBeSlow) // R01: the device reads 0.01 deg/s a unit, the host sends 1
{
    Robot robot(sinew::robot(R"(
version = 1
[bus.legs]
family = "rmd"
[joint.knee]
bus = "legs"
id = 1
model = "MG"
)"));
    const auto& knee = robot.resolved().joints[0];
    robot.command(knee, {.mode = Mode::position, .position_rad = units::rad(90), .velocity_rad_s = units::rad(50)},
                  robot.read(knee, Depth::full));
    robot.wait(2s);
    EXPECT_NEAR(units::deg(robot.look("knee").position_rad), 1.0, 0.1)
        << "a hundredth of the speed, and never a hundredfold";
}

} // namespace
} // namespace sinew
