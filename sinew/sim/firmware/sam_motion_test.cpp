#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/sim/firmware/sam_device.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using SamBench = Bench<SamDevice>;

sam::Spec spec_of(std::string_view model)
{
    sam::Spec spec{.model = sam::find_model(model), .profile = sam::profiles()[0], .id = 5};
    spec.device.response_level = 1;
    return spec;
}

TEST(SamMotion, ReachesTheSameAngleByEveryCoordinateOfEveryModel)
{
    for (const sam::Model& model : sam::models()) {
        SamBench bench(spec_of(model.name));
        const std::int64_t quarter = model.standard.centre + (model.standard.control.high - model.standard.centre) / 4;
        bench.ask(sam::PositionControl{.target_position = static_cast<std::uint16_t>(quarter)});
        bench.run(5s);
        EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, quarter) << model.name;
        EXPECT_NEAR(bench.device.look().position_rad, model.standard.rad(static_cast<double>(quarter)), 1e-12)
            << model.name;

        bench.ask(sam::QuickPositionControl{.torque_level = 0, .target_position = 200});
        bench.run(5s);
        EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 200) << model.name;
        EXPECT_NEAR(bench.device.look().position_rad, units::rad(73 * 1.08), 1e-12) << model.name;
        if (!model.precise)
            continue;
        bench.ask(sam::PrecisePositionControl{.target_position = 123'456});
        bench.run(5s);
        EXPECT_EQ(bench.ask(sam::ReadPrecisePosition{}).position, 123'456U) << model.name;
    }
}

TEST(SamMotion, ArrivesWhenItsSpeedAndTorqueSay)
{
    const auto spec = spec_of("SAM-160");
    const Rating rating = rating_of(spec);
    SamBench bench(spec);
    bench.ask(sam::SetCtrlSpeed{.ctrl_speed = 400});
    const double velocity = units::rad(400 * 0.2216);
    const double distance = spec.model->standard.rad(20'000);
    const double time_s = distance / velocity + velocity / rating.acceleration_max_rad_s2;
    bench.ask(sam::PositionControl{.target_position = 20'000});

    int steps = 0;
    while (bench.device.look().position_rad != distance && ++steps < 10'000)
        bench.run(1ms);
    EXPECT_NEAR(steps, time_s * 1000.0, 1.0);
}

TEST(SamMotion, TurnsAtTheControlSpeedAndTellsIt)
{
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetCtrlSpeed{.ctrl_speed = 400});
    bench.ask(sam::PositionControl{.target_position = 100});
    bench.run(500ms);
    EXPECT_EQ(bench.ask(sam::ReadCurrentSpeed{}).current_speed, -400);
    EXPECT_EQ(bench.ask(sam::ReadCurrentAccel{}).current_accel, 0);
    EXPECT_DOUBLE_EQ(bench.device.look().velocity_rad_s, -units::rad(400 * 0.2216));
}

TEST(SamMotion, TellsAnAccelerationAndALoadWhileItSpeedsUp)
{
    const auto spec = spec_of("SAM-160");
    SamBench bench(spec);
    bench.ask(sam::PositionControl{.target_position = 20'000});
    bench.run(20ms);
    const double acceleration = units::deg(rating_of(spec).acceleration_max_rad_s2) / 221.6;
    EXPECT_EQ(bench.ask(sam::ReadCurrentAccel{}).current_accel, std::lround(acceleration));
    EXPECT_EQ(bench.ask(sam::ReadCurrentLoad{}).current_load, 4095); // 5.5 A; saturates (S85)
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).load, 254);
}

TEST(SamMotion, TellsTheStateBeforeTheMotion)
{
    SamBench bench(spec_of("SAM-160"));
    EXPECT_EQ(bench.ask(sam::PositionControl{.target_position = 20'000}).position, 14'504);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickPositionControl{.target_position = 127}).position,
              127 + std::lround((20'000 - 14'504) * 0.01241 / 1.08));
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::PrecisePositionControl{.target_position = 150'000}).position, 101'529U);
}

TEST(SamMotion, StaysInsideTheBoundariesOfTheCoordinatesOfTheCommand)
{
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetBoundary{.lower_boundary = 63, .upper_boundary = 191});
    bench.ask(sam::PositionControl{.target_position = 28'000});
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(64 * 1.41), 1e-12);
    bench.ask(sam::QuickPositionControl{.target_position = 254});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 254);
    bench.ask(sam::QuickSetBoundary{.upper_boundary = 210, .lower_boundary = 44});
    bench.ask(sam::QuickPositionControl{.target_position = 1});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 44);
}

TEST(SamMotion, GoesToTheEndOfTheControlRangeForWhatLiesOutside)
{
    SamBench bench(spec_of("SAM-20"));
    bench.ask(sam::PositionControl{.target_position = 0});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 32);
    bench.ask(sam::PositionControl{.target_position = 32'639});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 4064);
    bench.ask(sam::QuickPositionControl{.target_position = 0});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 1);
}

TEST(SamMotion, DoesNotMoveWithoutTorque)
{
    SamBench bench(spec_of("SAM-20"));
    bench.ask(sam::SetAvgTorque{.avg_torque = 0});
    bench.ask(sam::PositionControl{.target_position = 3000});
    bench.ask(sam::QuickPositionControl{.target_position = 200});
    bench.run(5s);
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
}

TEST(SamMotion, SpeedsUpInProportionToItsTorque)
{
    const auto spec = spec_of("SAM-20");
    SamBench bench(spec);
    bench.ask(sam::QuickPositionControl{.torque_level = 4, .target_position = 200});
    bench.run(10ms);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, rating_of(spec).acceleration_max_rad_s2 / 5.0 * 0.010, 1e-9);
}

TEST(SamMotion, TurnsWithoutEndInWheelMode)
{
    const auto spec = spec_of("SAM-20");
    const double full = spec.model->ratings.max_speed_rad_s;
    SamBench bench(spec);
    bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::clockwise, .speed = 15});
    bench.run(5s);
    EXPECT_DOUBLE_EQ(bench.device.look().velocity_rad_s, full * 0.5);
    EXPECT_EQ(bench.device.look().mode, "wheel");
    const double turns = bench.device.look().position_rad / (2.0 * 3.14159265358979);
    EXPECT_EQ(bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::counter_clockwise, .speed = 1}).rotation_no,
              static_cast<int>(turns));
    bench.run(1s);
    EXPECT_DOUBLE_EQ(bench.device.look().velocity_rad_s, full * -0.15);
    bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 250});
    bench.run(1s);
    EXPECT_DOUBLE_EQ(bench.device.look().velocity_rad_s, full * 0.25);
    bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 1500});
    bench.run(1s);
    EXPECT_DOUBLE_EQ(bench.device.look().velocity_rad_s, full * -0.5);
    for (const int stop : {0, 1000}) {
        bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = static_cast<std::uint16_t>(stop)});
        bench.run(1s);
        EXPECT_EQ(bench.device.look().velocity_rad_s, 0.0);
    }
}

TEST(SamMotion, TurnsTheOtherWayWhenItsPositionsGrowCounterClockwise)
{
    auto spec = spec_of("SAM-20");
    spec.profile.clockwise_positive = false;
    SamBench bench(spec);
    bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::clockwise, .speed = 15});
    bench.run(1s);
    EXPECT_LT(bench.device.look().velocity_rad_s, 0.0);
}

TEST(SamMotion, CoastsWhenPassiveAndStopsShortWhenBraked)
{
    double travel[2] = {};
    for (const bool brake : {false, true}) {
        SamBench bench(spec_of("SAM-20"));
        bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::clockwise, .speed = 15});
        bench.run(1s);
        const double from = bench.device.look().position_rad;
        if (brake)
            bench.ask(sam::QuickBrakeMode{});
        else
            bench.ask(sam::QuickPassiveMode{});
        EXPECT_EQ(bench.device.look().mode, brake ? "brake" : "passive");
        bench.run(10s);
        EXPECT_EQ(bench.device.look().velocity_rad_s, 0.0);
        travel[brake] = bench.device.look().position_rad - from;
    }
    EXPECT_GT(travel[false], 5.0 * travel[true]);
}

TEST(SamMotion, HoldsWhereItIsInGeneralMode)
{
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SpecialControl{.mode = sam::Mode::passive});
    bench.ask(sam::SpecialControl{.mode = sam::Mode::position});
    bench.run(1s);
    EXPECT_EQ(bench.device.look().mode, "general");
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 14'504);
}

TEST(SamMotion, SeesEverythingTheOtherWayRoundInReverse)
{
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetDriveMode{.response_level = 1, .reverse = true});
    bench.ask(sam::PositionControl{.target_position = 20'000});
    bench.run(30ms);
    EXPECT_GT(bench.ask(sam::ReadCurrentSpeed{}).current_speed, 0);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 20'000);
    EXPECT_LT(bench.device.look().position_rad, 0.0);
}

TEST(SamMotion, TakesThePresentPositionForTheCentreAndTakesThatBack)
{
    auto spec = spec_of("SAM-160");
    spec.device.start_rad = units::rad(30.0);
    SamBench bench(spec);
    const auto before = bench.ask(sam::ReadCurrentPosition{}).position;
    EXPECT_EQ(before, std::lround(30.0 / 0.01241) + 14'504);
    bench.ask(sam::OffsetControl{.offset_control = 1});
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 14'504);
    bench.ask(sam::OffsetControl{.offset_control = 0});
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, before);
}

} // namespace
} // namespace sinew::sim
