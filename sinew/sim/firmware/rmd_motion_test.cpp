#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/sim/firmware/rmd_device.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

using test::covers;

using namespace std::chrono_literals;
using RmdBench = Bench<RmdDevice>;
using enum rmd::Spin;

rmd::Spec spec_of(std::string_view line = "rmd-2.35", const rmd::DeviceOptions& device = {})
{
    for (const rmd::Profile& profile : rmd::profiles())
        if (profile.line.name == line)
            return rmd::make_spec(*rmd::find_model("MF"), profile, 2, device);
    ADD_FAILURE() << "no line " << line;
    return {};
}

double degrees(const RmdBench& bench)
{
    return units::deg(bench.device.look().position_rad);
}

double degrees_per_second(const RmdBench& bench)
{
    return units::deg(bench.device.look().velocity_rad_s);
}

TEST(RmdMotion, TurnsAtTheCommandedSpeedAndTellsIt)
{
    covers("C 15");
    RmdBench bench(spec_of());
    bench.ask(rmd::SpeedClosedLoop{.speed = -36'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), -360.0, 1e-3);
    EXPECT_EQ(bench.ask(rmd::ReadStatus2{}).speed, -360);
}

TEST(RmdMotion, ArrivesWhenSpeedAndAccelerationSay)
{
    covers("C 5");
    RmdBench bench(spec_of());
    bench.ask(rmd::WriteAccelerationRam{.acceleration = 1000});
    bench.ask(rmd::MultiLoopAngleSpeed{.max_speed = 36'000, .angle = 180'000}); // 360 dps, 1800 deg
    const double target = units::rad(1800.0);
    int steps = 0;
    while (std::abs(bench.device.look().position_rad - target) > rest_rad && ++steps < 20'000)
        bench.run(1ms);
    EXPECT_NEAR(steps, 5000 + 360, settle_ms);
}

TEST(RmdMotion, ReadsMaxSpeedInTheScaleOfItsProfile)
{
    covers("C 17");
    auto spec = spec_of();
    spec.profile.max_speed_lsb_dps = 1.0;
    RmdBench bench(spec);
    bench.ask(rmd::MultiLoopAngleSpeed{.max_speed = 90, .angle = 1'000'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 90.0, 1e-3);
    RmdBench manual(spec_of());
    manual.ask(rmd::MultiLoopAngleSpeed{.max_speed = 9000, .angle = 1'000'000});
    manual.run(1s);
    EXPECT_NEAR(degrees_per_second(manual), 90.0, 1e-3);
}

TEST(RmdMotion, LimitsPositionOrdersBySpeedAndAngleOfTheParameters)
{
    covers("C 13");
    RmdBench bench(spec_of("rmd-2.35", {.max_speed_dps = 200.0, .max_angle_deg = 300.0}));
    bench.ask(rmd::MultiLoopAngle{.angle = -90'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), -200.0, 1e-3);
    bench.run(5s);
    EXPECT_NEAR(degrees(bench), -300.0, rest_deg);
    bench.ask(rmd::WriteParameterRam{rmd::ParameterId::max_speed, 5'000});
    bench.ask(rmd::WriteParameterRam{rmd::ParameterId::max_angle_low, 0});
    bench.ask(rmd::MultiLoopAngle{.angle = 90'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 50.0, 1e-3);
    bench.run(30s);
    EXPECT_NEAR(degrees(bench), 900.0, rest_deg);
}

TEST(RmdMotion, GoesRoundInTheGivenDirectionToASingleTurnAngle)
{
    covers("C 14");
    RmdBench bench(spec_of());
    bench.ask(rmd::SingleLoopAngle{.spin_direction = clockwise, .angle = 27'000});
    bench.run(5s);
    EXPECT_NEAR(degrees(bench), 270.0, rest_deg);
    bench.ask(rmd::SingleLoopAngle{.spin_direction = clockwise, .angle = 1'000});
    bench.run(5s);
    EXPECT_NEAR(degrees(bench), 370.0, rest_deg);
    bench.ask(rmd::SingleLoopAngleSpeed{.spin_direction = counter_clockwise, .max_speed = 36'000, .angle = 2'000});
    bench.run(5s);
    EXPECT_NEAR(degrees(bench), 20.0, rest_deg);
    for (const auto spin : {clockwise, counter_clockwise}) {
        bench.ask(rmd::SingleLoopAngle{.spin_direction = spin, .angle = 2'000});
        bench.run(5s);
        EXPECT_NEAR(degrees(bench), 20.0, rest_deg);
    }
}

TEST(RmdMotion, AddsIncrementsToTheTargetOrToThePosition)
{
    for (const auto base : {rmd::IncrementBase::target, rmd::IncrementBase::position}) {
        RmdBench bench(spec_of("rmd-2.35", {.increment_base = base}));
        bench.ask(rmd::IncrementAngle{.angle = 9'000});
        bench.ask(rmd::IncrementAngleSpeed{.max_speed = 36'000, .angle = -3'000});
        bench.run(5s);
        EXPECT_NEAR(degrees(bench), base == rmd::IncrementBase::target ? 60.0 : -30.0, rest_deg);
    }
}

TEST(RmdMotion, IsPushedByATorqueCurrentUpToItsNoLoadSpeed)
{
    const auto spec = spec_of();
    const PlantParameters plant = plant_of(spec);
    RmdBench bench(spec);
    bench.ask(rmd::TorqueClosedLoop{.iq = -124});
    bench.run(10ms);
    const double current_a = 124 * 16.5 / 2048;
    const double torque_nm = current_a * plant.torque_per_ampere_nm() - plant.coulomb_friction_nm;
    const double velocity = -torque_nm / plant.inertia_kg_m2() * 0.010;
    EXPECT_NEAR(bench.device.look().velocity_rad_s, velocity, 0.01 * -velocity); // viscous friction is left out
    bench.run(1s);
    const double most = rating_of(spec).velocity_max_rad_s;
    EXPECT_NEAR(bench.device.look().velocity_rad_s, -most, 0.01 * most);
}

TEST(RmdMotion, DrivesToTheSpeedOfItsOpenLoopPower)
{
    RmdBench bench(spec_of());
    EXPECT_EQ(bench.ask(rmd::TorqueOpenLoop{.power = 425}).power, 425);
    bench.run(1s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, rating_of(plant_of(spec_of()), 12.0).velocity_max_rad_s, 1e-6);
}

TEST(RmdMotion, StopsKeepingItsOrderAndRunsOn)
{
    covers("C 12");
    RmdBench bench(spec_of());
    bench.ask(rmd::MultiLoopAngleSpeed{.max_speed = 9'000, .angle = 36'000});
    bench.run(1s);
    bench.ask(rmd::MotorStop{});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 0.0, 1e-6);
    EXPECT_LT(degrees(bench), 100.0);
    EXPECT_EQ(bench.device.look().mode, "stopped");
    bench.ask(rmd::MotorRunning{});
    bench.run(5s);
    EXPECT_NEAR(degrees(bench), 360.0, rest_deg);
}

TEST(RmdMotion, SwitchesOffAndForgetsItsOrder)
{
    covers("C 12");
    RmdBench bench(spec_of());
    bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    bench.ask(rmd::MotorOff{});
    EXPECT_EQ(bench.device.look().mode, "off");
    bench.run(10s);
    EXPECT_EQ(degrees_per_second(bench), 0.0);
    bench.ask(rmd::MotorRunning{});
    bench.run(1s);
    EXPECT_EQ(degrees_per_second(bench), 0.0);
    bench.ask(rmd::MotorOff{});
    bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 360.0, 1e-3);
}

TEST(RmdMotion, OfAnLkMotorThatIsOffAnswersButWaitsForRunning)
{
    RmdBench bench(spec_of("lk-2.35"));
    bench.ask(rmd::MotorOff{});
    bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    EXPECT_EQ(degrees_per_second(bench), 0.0);
    bench.ask(rmd::MotorRunning{});
    bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 360.0, 1e-3);
}

TEST(RmdMotion, HasNoTorqueToTurnWithWhereTheSpeedOrderCarriesACurrentOfZero)
{
    RmdBench bench(spec_of("lk-2.36"));
    bench.ask(rmd::lk_2_36::SpeedClosedLoop{.iq = 0, .speed = 36'000});
    bench.run(1s);
    EXPECT_EQ(degrees_per_second(bench), 0.0);
    bench.ask(rmd::lk_2_36::SpeedClosedLoop{.iq = 500, .speed = 36'000});
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 360.0, 1e-3);
}

TEST(RmdMotion, StandsStillWhileItsBrakeIsEngaged)
{
    RmdBench bench(spec_of("lk-2.35"));
    EXPECT_EQ(bench.ask(rmd::lk::BrakeControl{.brake = 0}).brake, 0);
    bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    EXPECT_EQ(degrees(bench), 0.0);
    EXPECT_EQ(bench.ask(rmd::lk::BrakeControl{.brake = 0x10}).brake, 0);
    EXPECT_EQ(bench.ask(rmd::lk::BrakeControl{.brake = 1}).brake, 1);
    bench.run(1s);
    EXPECT_NEAR(degrees_per_second(bench), 360.0, 1e-3);
}

TEST(RmdMotion, StartsAgainAtASystemReset)
{
    RmdBench bench(spec_of("myactuator-3"));
    bench.ask(rmd::myactuator::SpeedClosedLoop{.speed = 36'000});
    bench.run(1s);
    EXPECT_FALSE(bench.send(rmd::myactuator::SystemReset{}));
    bench.run(10s);
    EXPECT_EQ(degrees_per_second(bench), 0.0);
}

TEST(RmdMotion, LimitsTheCurrentOfEveryLoopButTorqueByMaxTorqueCurrent)
{
    covers("C 13");
    constexpr std::int16_t raw = 40; // 0.32 A of the 3 A that the supply can give
    const auto greatest = [](const auto& order) {
        RmdBench bench(spec_of());
        bench.ask(rmd::WriteParameterRam{rmd::ParameterId::max_torque_current, raw});
        bench.ask(order);
        double most = 0.0;
        for (int i = 0; i < 100; ++i) {
            bench.run(1ms);
            most = std::max(most, std::abs(bench.device.look().current_a));
        }
        return most;
    };
    const double limit = raw * 16.5 / 2048 * (1 + 1e-9);
    for (const double most :
         {greatest(rmd::SpeedClosedLoop{.speed = 100'000}), greatest(rmd::MultiLoopAngle{.angle = 90'000}),
          greatest(rmd::MultiLoopAngleSpeed{.max_speed = 60'000, .angle = 90'000}),
          greatest(rmd::SingleLoopAngle{.spin_direction = clockwise, .angle = 27'000}),
          greatest(rmd::SingleLoopAngleSpeed{.spin_direction = clockwise, .max_speed = 60'000, .angle = 27'000}),
          greatest(rmd::IncrementAngle{.angle = 90'000}),
          greatest(rmd::IncrementAngleSpeed{.max_speed = 60'000, .angle = 90'000})}) {
        EXPECT_LE(most, limit);
        EXPECT_GT(most, 0.5 * limit);
    }
    EXPECT_GT(greatest(rmd::TorqueClosedLoop{.iq = 124}), 2.0 * limit);
    EXPECT_GT(greatest(rmd::TorqueOpenLoop{.power = 850}), 2.0 * limit);
}

TEST(RmdMotion, TellsTheStateOfTheFrameBeforeWhenItLags)
{
    for (const bool lags : {false, true}) {
        RmdBench bench(spec_of("rmd-2.35", {.reply_lag = lags}));
        bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
        bench.run(1s);
        EXPECT_EQ(bench.ask(rmd::SpeedClosedLoop{.speed = 36'000}).speed, lags ? 0 : 360);
        EXPECT_EQ(bench.ask(rmd::SpeedClosedLoop{.speed = 36'000}).speed, 360);
    }
}

} // namespace
} // namespace sinew::sim
