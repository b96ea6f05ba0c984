#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "sinew/sim/firmware/sam_device.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::covers;
using SamBench = Bench<SamDevice>;

/// Within which it takes an error for none; a precise unit of the largest model is 2.1e-5 rad.
constexpr double near_rad = 2.5e-5;

sam::Spec spec_of(std::string_view model)
{
    sam::Spec spec{.model = sam::find_model(model), .profile = sam::profiles()[0], .id = 5};
    spec.device.response_level = 1;
    return spec;
}

TEST(SamMotion, ReachesTheSameAngleByEveryCoordinateOfEveryModel)
{
    covers("A.3 2");
    covers("A.3 3");
    covers("A.3 7");
    for (const sam::Model& model : sam::models()) {
        SamBench bench(spec_of(model.name));
        const std::int64_t quarter = model.standard.centre + (model.standard.control.high - model.standard.centre) / 4;
        bench.ask(sam::PositionControl{.target_position = static_cast<std::uint16_t>(quarter)});
        bench.run(5s);
        EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, quarter) << model.name;
        EXPECT_NEAR(bench.device.look().position_rad, model.standard.rad(static_cast<double>(quarter)), near_rad)
            << model.name;

        bench.ask(sam::QuickPositionControl{.torque_level = 0, .target_position = 200});
        bench.run(5s);
        EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 200) << model.name;
        EXPECT_NEAR(bench.device.look().position_rad, units::rad(73 * 1.08), near_rad) << model.name;
        if (!model.precise)
            continue;
        bench.ask(sam::PrecisePositionControl{.target_position = 123'456});
        bench.run(5s);
        EXPECT_NEAR(bench.ask(sam::ReadPrecisePosition{}).position, 123'456, 2) << model.name;
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
    while (std::abs(bench.device.look().position_rad - distance) > 1e-3 && ++steps < 10'000)
        bench.run(1ms);
    // A loop without I lags behind, and comes in with the time constant D / P of 70 ms.
    EXPECT_GT(steps, time_s * 1000.0);
    EXPECT_LT(steps, time_s * 1000.0 + 5 * 70.0);
}

TEST(SamMotion, TurnsAtTheControlSpeedAndTellsIt)
{
    covers("A.13 1");
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetCtrlSpeed{.ctrl_speed = 400});
    bench.ask(sam::PositionControl{.target_position = 100});
    bench.run(500ms);
    EXPECT_EQ(bench.ask(sam::ReadCurrentSpeed{}).current_speed, -400);
    EXPECT_EQ(bench.ask(sam::ReadCurrentAccel{}).current_accel, 0);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, -units::rad(400 * 0.2216), 0.001); // half a unit is 0.002
}

TEST(SamMotion, TellsAnAccelerationAndALoadWhileItSpeedsUp)
{
    covers("A.13 2");
    covers("A.13 3");
    const auto spec = spec_of("SAM-160");
    SamBench bench(spec);
    bench.ask(sam::PositionControl{.target_position = 20'000});
    bench.run(20ms);
    const auto unit = [&] { return std::lround(units::deg(bench.device.plant().acceleration_rad_s2()) / 221.6); };
    EXPECT_EQ(bench.ask(sam::ReadCurrentAccel{}).current_accel, unit());
    EXPECT_GT(unit(), 10);                                           // 17 at rest, with full torque
    EXPECT_EQ(bench.ask(sam::ReadCurrentLoad{}).current_load, 4095); // 5.5 A; saturates (S85)
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).load, 254);
    bench.ask(sam::QuickBrakeMode{});
    bench.run(5ms);
    EXPECT_LT(bench.ask(sam::ReadCurrentAccel{}).current_accel, 0) << "slows down";
}

TEST(SamMotion, TellsTheStateBeforeTheMotion)
{
    covers("A.2 4");
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
    covers("A.4 1");
    covers("A.4 2");
    covers("A.4 3");
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetBoundary{.lower_boundary = 63, .upper_boundary = 191});
    bench.ask(sam::PositionControl{.target_position = 28'000});
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(64 * 1.41), near_rad);
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
    covers("A.3 1");
    covers("A.4 3");
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
    covers("A.3 4");
    SamBench bench(spec_of("SAM-20"));
    bench.ask(sam::SetAvgTorque{.avg_torque = 0});
    bench.ask(sam::PositionControl{.target_position = 3000});
    bench.ask(sam::QuickPositionControl{.target_position = 200});
    bench.run(5s);
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
}

TEST(SamMotion, SpeedsUpInProportionToItsTorque)
{
    covers("A.3 1");
    covers("A.3 2");
    covers("A.3 4");
    const auto speed = [](int level, int avg_torque) {
        SamBench bench(spec_of("SAM-20"));
        bench.ask(sam::SetAvgTorque{.avg_torque = static_cast<std::uint16_t>(avg_torque)});
        bench.ask(sam::QuickPositionControl{.torque_level = static_cast<std::uint8_t>(level), .target_position = 200});
        bench.run(10ms);
        return bench.device.look().velocity_rad_s;
    };
    const double full = speed(0, 2000);
    // Friction takes 3 % of the full torque.
    for (int level = 0; level <= 4; ++level)
        EXPECT_NEAR(speed(level, 2000) / full, (0.2 * (5 - level) - 0.03) / 0.97, 1e-6) << level;
    EXPECT_NEAR(speed(0, 1000) / full, (0.5 - 0.03) / 0.97, 1e-6);
}

TEST(SamMotion, TurnsWithoutEndInWheelMode)
{
    covers("A.7 1");
    covers("A.7 2");
    covers("A.7 3");
    covers("A.7 4");
    covers("A.7 5");
    covers("A.3 8");
    const auto spec = spec_of("SAM-20");
    // The printed speed at full duty; friction takes 3 % of it off every duty.
    const auto speed = [&](double duty) { return spec.model->ratings.max_speed_rad_s * (duty - 0.03) / 0.97; };
    SamBench bench(spec);
    bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::clockwise, .speed = 15});
    bench.run(5s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, speed(0.5), 1e-3);
    EXPECT_EQ(bench.device.look().mode, "wheel");
    const double turns = bench.device.look().position_rad / (2.0 * 3.14159265358979);
    EXPECT_EQ(bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::counter_clockwise, .speed = 1}).rotation_no,
              static_cast<int>(turns));
    bench.run(1s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, -speed(0.15), 1e-3);
    bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 250});
    bench.run(1s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, speed(0.25), 1e-3);
    bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 1500});
    bench.run(1s);
    EXPECT_NEAR(bench.device.look().velocity_rad_s, -speed(0.5), 1e-3);
    for (const int stop : {0, 1000}) {
        bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = static_cast<std::uint16_t>(stop)});
        bench.run(1s);
        EXPECT_EQ(bench.device.look().velocity_rad_s, 0.0);
    }
}

TEST(SamMotion, StaysInItsModeAtAPositionCommandWhenBuiltSo)
{
    covers("A.3 8");
    auto spec = spec_of("SAM-20");
    spec.device.position_ends_modes = false;
    SamBench bench(spec);
    bench.ask(sam::PositionControl{.target_position = 3000});
    bench.run(1s);
    EXPECT_EQ(bench.device.look().mode, "passive");
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
    bench.ask(sam::SpecialControl{.mode = sam::Mode::position});
    bench.ask(sam::PositionControl{.target_position = 3000});
    bench.run(2s);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 3000);
}

TEST(SamMotion, TurnsFasterInTheMiddleOfItsQuickWheelSpeedsWhenBuiltSo)
{
    covers("A.7 2");
    const auto speed = [](double middle_duty, std::uint8_t quick_speed) {
        auto spec = spec_of("SAM-20");
        spec.device.wheel_middle_duty = middle_duty;
        SamBench bench(spec);
        bench.ask(sam::QuickWheelMode{.direction = sam::QuickSpin::clockwise, .speed = quick_speed});
        bench.run(2s);
        return bench.device.look().velocity_rad_s / spec.model->ratings.max_speed_rad_s * 0.97 + 0.03;
    };
    for (const double middle : {0.325, 0.4}) {
        EXPECT_NEAR(speed(middle, 1), 0.15, 1e-3);
        EXPECT_NEAR(speed(middle, 8), middle, 1e-3);
        EXPECT_NEAR(speed(middle, 15), 0.5, 1e-3);
    }
    EXPECT_NEAR(speed(0.325, 4), 0.225, 1e-3);
}

TEST(SamMotion, StopsItsWheelAtTheBoundariesWhenBuiltSo)
{
    covers("A.7 5");
    auto spec = spec_of("SAM-20");
    spec.device.wheel_obeys_boundaries = true;
    SamBench bench(spec);
    bench.ask(sam::QuickSetBoundary{.upper_boundary = 177, .lower_boundary = 77}); // 54 degrees either way
    for (const auto& [direction, side] :
         {std::pair{sam::QuickSpin::clockwise, 1.0}, std::pair{sam::QuickSpin::counter_clockwise, -1.0}}) {
        bench.ask(sam::QuickWheelMode{.direction = direction, .speed = 1});
        bench.run(5s);
        EXPECT_EQ(bench.device.look().velocity_rad_s, 0.0);
        EXPECT_NEAR(units::deg(bench.device.look().position_rad), side * 54.0, 5.0) << "where it has stopped";
        EXPECT_GE(side * units::deg(bench.device.look().position_rad), 54.0);
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
    covers("A.5 2");
    covers("A.6 1");
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
    covers("A.13 7");
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

TEST(SamMotion, MeasuresItsSpeedOverTheWindowOfItsModel)
{
    covers("A.13 1");
    for (const auto* name : {"SAM-20", "SAM-160"}) {
        const auto spec = spec_of(name);
        SamBench bench(spec);
        bench.ask(sam::QuickPositionControl{.target_position = 200});
        bench.run(20ms);
        const double before = bench.device.look().position_rad;
        bench.run(spec.model->speed_window);
        const double speed = (bench.device.look().position_rad - before) / seconds(spec.model->speed_window);
        EXPECT_EQ(bench.ask(sam::ReadCurrentSpeed{}).current_speed,
                  std::lround(units::deg(speed) / spec.model->speed_deg_s_per_unit))
            << name;
    }
}

TEST(SamMotion, ReadsItsAccelerationAndItsLoadOverTheLastMillisecond)
{
    covers("A.13 2");
    covers("A.13 3");
    const auto spec = spec_of("SAM-160");
    SamBench bench(spec);
    bench.ask(sam::QuickPositionControl{.torque_level = 4, .target_position = 200}); // a fifth of the voltage
    bench.run(8ms);
    const double before = bench.device.look().velocity_rad_s;
    bench.run(1ms);
    const double after = bench.device.look().velocity_rad_s;
    const double acceleration = (after - before) / 0.001;
    EXPECT_EQ(bench.ask(sam::ReadCurrentAccel{}).current_accel,
              std::lround(units::deg(acceleration) / spec.model->accel_deg_s2_per_unit));
    const PlantParameters& p = bench.device.plant().parameters();
    const double torque = p.inertia_kg_m2() * acceleration + p.coulomb_friction_nm +
                          p.viscous_friction_nm_s_per_rad * (before + after) / 2.0;
    const double mean_a = torque / p.torque_per_ampere_nm();
    const double at_end_a = (0.2 * 24.0 - p.voltage_constant_v_s_per_rad() * after) / p.winding_ohm;
    ASSERT_GT(std::abs(mean_a - at_end_a) / spec.model->current_a_per_ad12, 2.0) << "the window would not matter";
    EXPECT_NEAR(bench.ask(sam::ReadCurrentLoad{}).current_load, mean_a / spec.model->current_a_per_ad12, 1.0);
    EXPECT_NEAR(bench.ask(sam::QuickReadStatus{}).load, mean_a / spec.model->current_a_per_ad8, 1.0);
}

TEST(SamMotion, HoldsAgainstAHandThatWouldTurnItWhenPassive)
{
    covers("A.3 6");
    covers("A.5 1");
    covers("A.6 1");
    const auto pushed = [](const auto& message) {
        SamBench bench(spec_of("SAM-160"));
        bench.ask(message);
        bench.run(100ms);
        bench.device.plant().push(2.0); // of 15.7 N·m; friction holds 0.63 N·m
        bench.run(100ms);
        EXPECT_LE(std::abs(bench.device.plant().supply_current_a()), 1.0);
        const auto raw = bench.ask(sam::ReadCurrentPosition{}).position;
        EXPECT_EQ(raw, std::lround(units::deg(bench.device.look().position_rad) / 0.01241) + 14'504);
        return bench.device.look().position_rad;
    };
    const double passive = pushed(sam::QuickPassiveMode{});
    EXPECT_GT(passive, 0.02);
    EXPECT_LT(pushed(sam::QuickBrakeMode{}), 0.75 * passive);
    EXPECT_LT(pushed(sam::PositionControl{.target_position = 14'504}), 0.02);
}

TEST(SamMotion, BrakesWithoutTakingAnythingFromTheSupply)
{
    covers("A.6 1");
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::QuickBrakeMode{});
    bench.device.plant().push(5.0);
    bench.run(1s);
    EXPECT_EQ(bench.device.plant().supply_current_a(), 0.0);
    EXPECT_GT(std::abs(bench.device.look().current_a), 0.5) << "the winding is shorted";
}

} // namespace
} // namespace sinew::sim
