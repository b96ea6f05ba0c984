#include "tests/robot/watch.hpp"

#include <gtest/gtest.h>

/// Joints that are beyond a limit, or would be if nobody took care.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// A knee that begins 49 deg beyond its limit; the hole is for its bus.
constexpr std::string_view knee_beyond = R"(
version = 1
[bus.r]
family = "rmd"
{}
[joint.knee]
bus = "r"
id = 1
model = "MG"
profile = "rmd-2.35"
position_max_deg = 100
velocity_max_deg_s = 180
[joint.knee.sim]
start_rad = 2.6
)";

TEST(Beyond, AJointThatWasToldToHoldOnItsWayBackIsNotSentOutAgainToWhereItWasTold)
{
    Rig rig(file_of(fmt::format(knee_beyond, "")));
    rig.enable();
    Joint& knee = *rig.robot->find("knee");
    ASSERT_EQ(said(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(-150)})), "");
    ASSERT_EQ(said(rig.run(150ms, 5ms)), "");
    ASSERT_EQ(said(knee.set({.mode = Mode::hold})), "");
    const double told_at = *knee.state().position_rad;
    ASSERT_EQ(said(rig.run(200ms, 5ms)), "");
    const double rests_at = *knee.state().position_rad;
    ASSERT_GT(rests_at, units::rad(105));
    ASSERT_LT(rests_at, told_at - units::rad(0.3));
    EXPECT_FALSE(knee.set({.mode = Mode::position, .position_rad = rests_at + units::rad(0.2)}));
    EXPECT_TRUE(knee.set({.mode = Mode::position, .position_rad = rests_at - units::rad(0.2)}));
}

/// Told while an exchange is under way, which measures it anew before that goes out.
TEST(Beyond, AJointOnItsWayBackIsNotSentOutAgainToWhereItWasWhenItWasTold)
{
    Rig rig(file_of(fmt::format(knee_beyond, "rate_hz = 100")));
    rig.enable();
    Watch watch(rig);
    Joint& knee = *rig.robot->find("knee");
    ASSERT_EQ(said(knee.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(-40)})), "");
    ASSERT_EQ(said(rig.run(50ms)), "");
    double told_rad = 0.0;
    watch.runs_itself();
    ASSERT_EQ(said(rig.robot->run(
                  100us,
                  [&](Robot&) {
                      if (knee.command().mode == Mode::velocity &&
                          rig.now() - knee.state().position_rad.at() > 9700us) {
                          told_rad = *knee.state().position_rad;
                          ASSERT_EQ(said(knee.set({.mode = Mode::position, .position_rad = told_rad})), "");
                      }
                  },
                  rig.now() + 500ms)),
              "");
    ASSERT_GT(units::deg(told_rad), 110.0);
    EXPECT_LT(units::deg(*knee.state().position_rad), units::deg(told_rad) - 0.3);
    EXPECT_TRUE(watch.complaints().empty()) << watch.complaints()[0];
}

TEST(Beyond, AServoThatWasHeatedJustBeforeItsLimitDoesNotCoastFarBeyondIt)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[safety]\npolicy = \"hold\"\n[joint.wrist]\nbus = \"s\"\n"
                    "id = 2\nmodel = \"SAM-20\"\nposition_min_deg = -50\nposition_max_deg = 40\n"
                    "velocity_max_deg_s = 200\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("wrist", {.mode = Mode::velocity, .velocity_rad_s = units::rad(190)})), "");
    bool heated = false;
    double ended_at = 0.0, speed = 0.0;
    const auto ran = rig.robot->run(
        5ms,
        [&](Robot& robot) {
            // Between two whole readings, which are half a second apart.
            if (!heated && rig.truth_rad("wrist") > units::rad(20)) {
                rig.inject(sim::FaultKind::hot_motor, "wrist");
                heated = true;
            }
            if (robot.find("wrist")->command().mode == Mode::velocity) {
                ended_at = rig.truth_rad("wrist");
                speed = rig.truth_rad_s("wrist");
            }
        },
        rig.now() + 3s);
    ASSERT_TRUE(heated);
    ASSERT_FALSE(ran.has_value());
    ASSERT_FALSE(rig.robot->incidents().empty());
    EXPECT_NE(rig.robot->incidents()[0].says.find("limit"), std::string::npos) << rig.robot->incidents()[0].says;
    EXPECT_LT(units::deg(rig.truth_rad("wrist") - ended_at), units::deg(speed) * 0.03 + 15.0) << "it coasted";
}

/// A SAM that is too hot controls no position: told to hold, it would coast, and leap when it has cooled.
TEST(Beyond, AServoThatIsTooHotToHoldIsBrakedAndDoesNotCoastOnNorLeapWhenItHasCooled)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[safety]\npolicy = \"hold\"\n[joint.wrist]\nbus = \"s\"\n"
                    "id = 2\nmodel = \"SAM-20\"\nposition_min_deg = -150\nposition_max_deg = 150\n"
                    "velocity_max_deg_s = 200\n"));
    rig.enable();
    ASSERT_EQ(said(rig.robot->set("wrist", {.mode = Mode::velocity, .velocity_rad_s = units::rad(190)})), "");
    ASSERT_EQ(said(rig.run(400ms, 5ms)), "");
    const double speed = rig.truth_rad_s("wrist");
    ASSERT_GT(speed, units::rad(130));
    rig.inject(sim::FaultKind::hot_motor, "wrist");
    double told_at = 0.0;
    const auto ran = rig.robot->run(5ms, [&](Robot&) { told_at = rig.truth_rad("wrist"); }, rig.now() + 2s);
    ASSERT_FALSE(ran.has_value());
    EXPECT_NE(said(ran).find("over temperature"), std::string::npos) << said(ran);
    EXPECT_NEAR(rig.truth_rad_s("wrist"), 0.0, units::rad(1));
    const double stopped_at = rig.truth_rad("wrist");
    EXPECT_LT(units::deg(stopped_at - told_at), 20.0) << "it coasted";
    const auto stopped = rig.robot->stop();
    EXPECT_EQ(stopped[0].did, Mode::brake);
    EXPECT_EQ(stopped[0].outcome, Stopped::Outcome::confirmed);
    sim::Fault cool{.kind = sim::FaultKind::hot_motor, .joint = "wrist"};
    cool.temperature_c = 25.0;
    rig.simulator->world().inject(cool);
    for (int i = 0; i < 200; ++i) {
        static_cast<void>(rig.robot->cycle());
        rig.simulator->clock().wait({}, rig.now() + 5ms);
    }
    EXPECT_NEAR(units::deg(rig.truth_rad("wrist")), units::deg(stopped_at), 1.0) << "it leapt";
}

/// Enabled and moved by hand before it has cooled.
TEST(Beyond, AServoThatIsEnabledWhileItIsTooHotDoesNotLeapToWhereItStoodWhenItHasCooled)
{
    Rig rig(
        file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.wrist]\nbus = \"s\"\nid = 2\nmodel = \"SAM-20\"\n"));
    rig.inject(sim::FaultKind::hot_motor, "wrist");
    rig.simulator->clock().wait({}, rig.now() + 100ms);
    rig.enable();
    const double enabled_at = rig.truth_rad("wrist");
    sim::Fault push{.kind = sim::FaultKind::push, .joint = "wrist", .for_s = 0.5};
    push.torque_nm = 1.0;
    rig.simulator->world().inject(push);
    rig.simulator->clock().wait({}, rig.now() + 1s);
    const double pushed_to = rig.truth_rad("wrist");
    ASSERT_GT(std::abs(pushed_to - enabled_at), units::rad(5)) << "too little to tell";
    sim::Fault cool{.kind = sim::FaultKind::hot_motor, .joint = "wrist"};
    cool.temperature_c = 25.0;
    rig.simulator->world().inject(cool);
    rig.simulator->clock().wait({}, rig.now() + 1s);
    EXPECT_NEAR(units::deg(rig.truth_rad("wrist")), units::deg(pushed_to), 1.0) << "it leapt";
}

TEST(Beyond, AJointBeyondALimitIsStreamedBackInsideAndNoFurtherOut)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-160EO200\"\nposition_min_deg = -20\nposition_max_deg = 60\nvelocity_max_deg_s = 60\n"
                    "step_max_deg = 2\n[joint.arm.sim]\nstart_rad = 1.1\n"));
    rig.enable();
    Joint& arm = *rig.robot->find("arm");
    const double out = *arm.state().position_rad;
    ASSERT_GT(out, units::rad(62));
    const auto refused = [&](double position_rad) {
        return !arm.set({.mode = Mode::position, .position_rad = position_rad}).has_value();
    };
    ASSERT_EQ(said(rig.run(100ms)), "");
    EXPECT_TRUE(refused(out + units::rad(0.2))) << "further out";
    EXPECT_TRUE(refused(out - units::rad(2.5))) << "the largest step holds there, too";
    for (double to = out; to > units::rad(55); to -= units::rad(0.25)) {
        ASSERT_EQ(said(arm.set({.mode = Mode::position, .position_rad = to})), "") << units::deg(to);
        ASSERT_EQ(said(rig.robot->cycle()), "");
        if (to < out - units::rad(0.5)) {
            EXPECT_TRUE(refused(std::max(to + units::rad(0.2), units::rad(60.01)))) << units::deg(to);
        }
        rig.simulator->clock().wait({}, rig.now() + 5ms);
    }
    ASSERT_EQ(said(rig.run(500ms)), "");
    EXPECT_NEAR(units::deg(rig.truth_rad("arm")), 55.0, 0.5);
    EXPECT_TRUE(refused(units::rad(60.1))) << "who came back may not leave again";
}

/// A walk begins where it is, and not where it was when the latest cycle was planned.
TEST(Beyond, AServoThatTurnsBackFromBeyondALimitIsNotSentOutAgainWhenAWalkBegins)
{
    Rig rig(file_of("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                    "model = \"SAM-20\"\nposition_max_deg = 0\nvelocity_max_deg_s = 200\n"
                    "[joint.arm.sim]\nstart_rad = 1.5\n"));
    rig.enable();
    Watch watch(rig);
    Joint& arm = *rig.robot->find("arm");
    const auto cycle = [&] {
        watch.cycle_begins();
        ASSERT_EQ(said(rig.robot->cycle()), "");
        rig.simulator->clock().wait({}, rig.now() + 5ms);
    };
    ASSERT_EQ(said(arm.set({.mode = Mode::velocity, .velocity_rad_s = units::rad(-150)})), "");
    while (rig.truth_rad("arm") > units::rad(40))
        cycle();
    ASSERT_LT(rig.truth_rad_s("arm"), units::rad(-80));
    ASSERT_EQ(said(arm.set({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = units::rad(150)})), "");
    for (int i = 0; i < 10; ++i)
        cycle();
    EXPECT_EQ(watch.complaints(), std::vector<std::string>());
}

} // namespace
} // namespace sinew::robot::test
