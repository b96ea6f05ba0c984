#include "tests/robot/rig.hpp"

/// A stop where a joint does not answer any more.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

TEST(Silent, AStopDoesNotWaitLongForAJointThatIsUnplugged)
{
    auto file = demo();
    file.safety.silence_max_s = 100.0;
    bus::Settings patient;
    patient.margin_at_first = patient.margin_least = patient.margin_most = 1s;
    Rig rig(file, patient);
    rig.enable();
    for (const auto* joint : {"elbow", "waist_yaw", "left_hip"})
        ASSERT_EQ(said(rig.robot->set(joint, {.mode = Mode::position, .position_rad = 0.4, .velocity_rad_s = 0.1})),
                  "");
    ASSERT_EQ(said(rig.run(500ms)), "");
    rig.inject(sim::FaultKind::unplug, "elbow");
    rig.simulator->clock().wait({}, rig.now() + 50ms);
    const TimePoint begun = rig.now();
    for (const auto& one : rig.robot->stop())
        EXPECT_EQ(one.outcome, one.joint == "elbow" ? Stopped::Outcome::failed : Stopped::Outcome::confirmed)
            << one.joint;
    EXPECT_LT(rig.now() - begun, 5s) << "four time-outs, and looks at those that are there";
}

} // namespace
} // namespace sinew::robot::test
