#include "tests/robot/rig.hpp"

#include <gtest/gtest.h>

/// A mixed robot by its joints: units, enabling, cycles, states.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Robot, EveryJointOfTheDemoHoldsAfterEnableAndGoesWhereItIsSent)
{
    Rig rig(demo());
    rig.enable();
    ASSERT_EQ(rig.robot->joints().size(), 16U);
    for (Joint& joint : rig.robot->joints()) {
        EXPECT_NEAR(*joint.state().position_rad, 0.0, 2 * joint.capabilities().position_step_rad) << joint.name();
        EXPECT_EQ(joint.command().mode, Mode::hold);
        const double to =
            joint.limits().position_low_rad.value_or(-1) < units::rad(-60) ? units::rad(-20) : units::rad(20);
        const auto set = joint.set({.mode = Mode::position, .position_rad = to, .velocity_rad_s = units::rad(40)});
        ASSERT_TRUE(set.has_value()) << said(set);
    }
    const auto ran = rig.run(2s);
    ASSERT_TRUE(ran.has_value()) << said(ran);
    for (const Joint& joint : rig.robot->joints()) {
        const double step = joint.capabilities().position_step_rad;
        const double to = *joint.command().position_rad;
        EXPECT_NEAR(rig.truth_rad(joint), to, step) << joint.name();
        EXPECT_NEAR(*joint.state().position_rad, rig.truth_rad(joint), step) << joint.name();
        EXPECT_EQ(joint.failures(), 0U) << joint.name();
        EXPECT_LT(joint.state().position_rad.age(rig.now()), 50ms) << joint.name();
        EXPECT_TRUE(joint.state().velocity_rad_s.has_value()) << joint.name();
    }
    EXPECT_TRUE(rig.robot->incidents().empty()) << rig.robot->incidents()[0].says;
}

TEST(Robot, AJointTurnsByItsDirectionZeroAndRatio)
{
    Rig rig(file_of(R"(
version = 1
[bus.r]
family = "rmd"
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
direction = -1
zero_deg = 30
ratio = 2
velocity_max_deg_s = 90
)"));
    rig.enable();
    Joint& knee = *rig.robot->find("knee");
    EXPECT_NEAR(*knee.state().position_rad, units::rad(15), 1e-3) << "(0 - 30) / (-1 * 2)";
    ASSERT_TRUE(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(45)}));
    ASSERT_TRUE(rig.run(1s));
    EXPECT_NEAR(*knee.state().velocity_rad_s, units::rad(45), units::rad(1));
    EXPECT_NEAR(rig.simulator->world().look("knee")->velocity_rad_s, units::rad(-90), units::rad(2));
    ASSERT_TRUE(knee.set({.mode = Mode::position, .position_rad = units::rad(-10)}));
    ASSERT_TRUE(rig.run(2s));
    EXPECT_NEAR(rig.simulator->world().look("knee")->position_rad, units::rad(50), units::rad(0.02));
}

TEST(Robot, AMoveWithAVelocityOrADurationTakesItsTimeInEveryFamily)
{
    for (const bool timed : {false, true}) {
        Rig rig(demo());
        rig.enable();
        for (Joint& joint : rig.robot->joints()) {
            const double to = joint.name().ends_with("hip") ? units::rad(-20) : units::rad(20);
            Command go{.mode = Mode::position, .position_rad = to};
            if (timed)
                go.duration = 2s;
            else
                go.velocity_rad_s = units::rad(10);
            const auto set = joint.set(go);
            ASSERT_TRUE(set.has_value()) << said(set);
        }
        ASSERT_TRUE(rig.run(1s));
        for (Joint& joint : rig.robot->joints())
            EXPECT_NEAR(std::abs(units::deg(rig.truth_rad(joint))), 10.0, 1.5) << joint.name() << timed;
        ASSERT_TRUE(rig.run(1300ms));
        for (Joint& joint : rig.robot->joints())
            EXPECT_NEAR(std::abs(units::deg(rig.truth_rad(joint))), 20.0, 0.1) << joint.name() << timed;
    }
}

TEST(Robot, AModelThatIsNotTheDevicesOwnIsNotEnabled)
{
    const auto with_model = [](std::string_view model) {
        return file_of(fmt::format("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.servo]\nbus = \"s\"\nid = 1\n"
                                   "model = \"{}\"\n",
                                   model));
    };
    Rig rig(with_model("SAM-20"), with_model("SAM-28"));
    const auto on = rig.robot->enable();
    ASSERT_FALSE(on.has_value());
    EXPECT_NE(said(on).find("SAM-20"), std::string::npos) << said(on);
    EXPECT_NE(said(on).find("SAM-28"), std::string::npos) << said(on);
    EXPECT_FALSE(rig.robot->enabled());
    EXPECT_FALSE(rig.robot->set("servo", {.mode = Mode::hold}));
}

TEST(Robot, AnUnknownJointIsAnErrorWithTheNearestName)
{
    Rig rig(demo());
    const auto set = rig.robot->set("elbo", {.mode = Mode::hold});
    ASSERT_FALSE(set.has_value());
    EXPECT_NE(said(set).find("elbow"), std::string::npos);
    EXPECT_FALSE(rig.robot->state("elbo").has_value());
}

TEST(Robot, ASlowBusNeverHoldsUpAFastOne)
{
    auto file = demo();
    for (auto& bus : file.buses)
        if (bus.name == "waist")
            bus.bit_rate = config::Marked<std::int64_t>{9600, {}};
    Rig rig(file);
    rig.enable();
    int calls = 0;
    Duration oldest_fast{}, oldest_slow{};
    const auto ran = rig.robot->run(
        2ms,
        [&](Robot& robot) {
            if (++calls < 200)
                return;
            for (const Joint& joint : robot.joints()) {
                auto& oldest = joint.bus() == "legs" ? oldest_fast : oldest_slow;
                oldest = std::max(oldest, *joint.state().position_rad.age(rig.now()));
            }
        },
        rig.now() + 2s);
    ASSERT_TRUE(ran.has_value()) << said(ran);
    EXPECT_GE(calls, 990);
    EXPECT_LT(oldest_fast, 8ms);
    EXPECT_GT(oldest_slow, 20ms) << "its age says how old it is";
}

} // namespace
} // namespace sinew::robot::test
