#include "sinew/sim/firmware/sam_position_loop.hpp"
#include "sinew/sim/firmware/sam_settings.hpp"
#include "sinew/sim/firmware/servo.hpp"
#include "tests/robot/rig.hpp"

#include <gtest/gtest.h>

/// Where joints come to rest, beside where they were sent.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// Sends every joint of the demo robot to a few places; `look` is what is expected of each at rest.
void send_to_and_fro(Rig& rig, const std::function<void(const Joint&)>& look)
{
    rig.enable();
    for (const double to_deg : {-12.3456, -1.0, -33.3}) {
        for (Joint& joint : rig.robot->joints()) {
            const double sense = joint.limits().position_low_rad.value_or(-1) > units::rad(-40) ? -0.1 : 1.0;
            ASSERT_EQ(said(joint.set({.mode = Mode::position,
                                      .position_rad = sense * units::rad(to_deg),
                                      .velocity_rad_s = units::rad(40)})),
                      "");
        }
        ASSERT_EQ(said(rig.run(4s)), "");
        for (const Joint& joint : rig.robot->joints()) {
            EXPECT_NEAR(rig.truth_rad_s(joint.name()), 0.0, 1e-3) << joint.name() << " is not at rest";
            EXPECT_NEAR(*joint.state().position_rad, rig.truth_rad(joint), joint.capabilities().position_step_rad)
                << joint.name();
            look(joint);
        }
    }
}

/// A plant that nothing holds up: no friction, nothing to carry.
config::RobotFile without_friction(config::RobotFile file)
{
    for (auto& joint : file.joints)
        for (const auto* key : {"static_friction_nm", "coulomb_friction_nm"})
            joint.plant.push_back({key, 0.0, {}});
    return file;
}

TEST(Rest, EveryJointIsWithinOneStepOfItsEncoderWhereNothingHoldsItUp)
{
    Rig rig(without_friction(demo()));
    send_to_and_fro(rig, [&](const Joint& joint) {
        EXPECT_NEAR(rig.truth_rad(joint), *joint.command().position_rad, joint.capabilities().position_step_rad)
            << joint.name();
    });
}

/// A shaft that sticks moves only when the loop pushes harder than the static friction holds. The proportional part
/// alone, without what a loop adds against friction or gathers in time, pushes by its stiffness for each radian of
/// error, so a shaft that rests is no further off than static friction / stiffness. Of a motor at rest:
/// - SAM: P · duty per radian of the supply, and the whole supply gives the stall torque, supply / winding · torque per
///   ampere;
/// - Nuri and RMD: a current that accelerates the shaft by ω² for each radian, so ω² · inertia is the torque.
double dead_band_rad(const Joint& joint, const sim::Plant& plant, double supply_v)
{
    const auto& p = plant.parameters();
    double stiffness_nm_per_rad = sim::Servo::frequency_rad_s * sim::Servo::frequency_rad_s * p.inertia_kg_m2();
    if (joint.family().name == "sam")
        stiffness_nm_per_rad = sim::SamGains{}.p * sim::SamPositionLoop::p_duty_per_rad * supply_v / p.winding_ohm *
                               p.torque_per_ampere_nm();
    return p.static_friction_nm / stiffness_nm_per_rad / joint.file().ratio;
}

TEST(Rest, EveryJointIsWithinTheDeadBandOfItsFrictionAndGainAndOneStepOfItsEncoder)
{
    Rig rig(demo());
    send_to_and_fro(rig, [&](const Joint& joint) {
        const auto& plant = rig.simulator->world().find_device(joint.name())->plant();
        const double band = dead_band_rad(joint, plant, rig.simulator->world().look(joint.name())->voltage_v);
        EXPECT_GT(plant.parameters().static_friction_nm, 0.0) << joint.name() << " has friction";
        EXPECT_GT(band, 0.0) << joint.name();
        EXPECT_LT(band, units::rad(1.0)) << joint.name() << ": a bound that bounds nothing";
        EXPECT_NEAR(rig.truth_rad(joint), *joint.command().position_rad, band + joint.capabilities().position_step_rad)
            << joint.name();
    });
}

} // namespace
} // namespace sinew::robot::test
