#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/sam_device.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::covers;

sam::Spec spec_of(std::string_view model)
{
    sam::Spec spec{.model = sam::find_model(model), .profile = sam::profiles()[0], .id = 5};
    spec.device.response_level = 1;
    return spec;
}

/// A stuck SAM that is told to turn: from the next tick on the stall current flows.
struct Stuck : Bench<SamDevice> {
    explicit Stuck(const sam::Spec& spec) : Bench(spec)
    {
        device.plant().jam(true);
        ask(sam::QuickPositionControl{.torque_level = 0, .target_position = 200});
        run(1ms);
    }
    bool is_passive() const { return device.look().mode == "passive"; }
};

TEST(SamProtection, LetsGoAfterTwoTenthsOfASecondAboveItsOverloadAndComesBack)
{
    covers("A.8 1");
    covers("A.8 4");
    covers("A.5 2");
    Stuck bench(spec_of("SAM-160")); // 5 A against 4.095 A
    bench.run(200ms);
    EXPECT_FALSE(bench.is_passive());
    bench.run(1ms);
    EXPECT_TRUE(bench.is_passive());
    EXPECT_EQ(bench.device.look().faults, "overload");
    EXPECT_TRUE(bench.device.port().led_blue);
    EXPECT_EQ(bench.device.look().current_a, 0.0);
    bench.run(299ms);
    EXPECT_TRUE(bench.is_passive());
    EXPECT_TRUE(bench.device.port().led_blue);
    bench.device.plant().jam(false);
    bench.run(1ms);
    EXPECT_EQ(bench.device.look().mode, "general");
    EXPECT_EQ(bench.device.look().faults, "");
    EXPECT_FALSE(bench.device.port().led_blue);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 200);
}

TEST(SamProtection, BearsAnOverloadThatIsShort)
{
    covers("A.8 1");
    Stuck bench(spec_of("SAM-160"));
    bench.run(199ms);
    bench.device.plant().jam(false);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 200);
}

TEST(SamProtection, StaysPassiveWhenBuiltSo)
{
    covers("A.8 4");
    auto spec = spec_of("SAM-160");
    spec.device.overload_resume = sam::OverloadResume::stay_passive;
    Stuck bench(spec);
    bench.run(201ms);
    bench.device.plant().jam(false);
    bench.run(5s);
    EXPECT_TRUE(bench.is_passive());
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
    bench.ask(sam::QuickPositionControl{.target_position = 200});
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 200);
}

TEST(SamProtection, KeepsACommandForTheEndOfThePassiveTime)
{
    covers("A.8 1");
    Stuck bench(spec_of("SAM-160"));
    bench.run(201ms);
    bench.device.plant().jam(false);
    bench.ask(sam::QuickPositionControl{.target_position = 100});
    bench.run(290ms);
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::QuickReadStatus{}).position, 100);
}

TEST(SamProtection, CountsTheOverloadInTheUnitsOfBothCommands)
{
    covers("A.8 3");
    for (const bool quick : {false, true}) {
        for (const int amperes : {1, 3}) { // a stuck SAM-20 draws 2 A
            Stuck bench(spec_of("SAM-20"));
            if (quick)
                bench.ask(sam::QuickSetOverload{.overload = static_cast<std::uint8_t>(amperes / 0.01289)});
            else
                bench.ask(sam::SetOverload{.overload = static_cast<std::uint16_t>(amperes / 0.00081)});
            bench.run(300ms);
            EXPECT_EQ(bench.is_passive(), amperes == 1) << quick;
        }
    }
}

TEST(SamProtection, LetsGoForFiveSecondsAfterASecondAboveOnePointEightAmperes)
{
    covers("A.8 2");
    Stuck bench(spec_of("SAM-20")); // 2 A
    bench.run(1s);
    EXPECT_FALSE(bench.is_passive());
    bench.run(1ms);
    EXPECT_TRUE(bench.is_passive());
    bench.run(4999ms);
    EXPECT_TRUE(bench.is_passive());
    bench.run(1ms);
    EXPECT_FALSE(bench.is_passive());
}

TEST(SamProtection, HasNoFixedLimitWhenItIsTurnedOff)
{
    covers("A.8 2");
    auto spec = spec_of("SAM-20");
    spec.device.fixed_overload_a = 0.0;
    Stuck bench(spec);
    bench.run(10s);
    EXPECT_FALSE(bench.is_passive());
}

TEST(SamProtection, LetsGoInWheelModeAndTurnsOnAfterwards)
{
    covers("A.8 4");
    Stuck bench(spec_of("SAM-160"));
    bench.ask(sam::SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 999});
    bench.run(201ms);
    EXPECT_TRUE(bench.is_passive());
    bench.device.plant().jam(false);
    bench.run(1s);
    EXPECT_EQ(bench.device.look().mode, "wheel");
    EXPECT_GT(bench.device.look().velocity_rad_s, 1.0);
}

TEST(SamProtection, StopsPositionControlWhileItIsHot)
{
    covers("A.8 5");
    Bench<SamDevice> bench(spec_of("SAM-160"));
    bench.device.plant().heat_to(64.9);
    bench.run(1ms);
    EXPECT_EQ(bench.ask(sam::ReadTemperatureError{}).temp_error, 0);
    bench.device.plant().heat_to(66.0);
    bench.ask(sam::PositionControl{.target_position = 20'000});
    int red = 0;
    for (int k = 0; k < 1000; ++k) {
        bench.run(1ms);
        red += bench.device.port().led_red;
    }
    EXPECT_NEAR(red, 500, 1) << "blinks";
    EXPECT_EQ(bench.ask(sam::ReadTemperatureError{}).temp_error, 1);
    EXPECT_EQ(bench.device.look().faults, "hot");
    EXPECT_NEAR(bench.device.look().temperature_c, 66.0, 0.1);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 14'504);
    bench.device.plant().heat_to(40.0);
    bench.run(5s);
    EXPECT_EQ(bench.ask(sam::ReadTemperatureError{}).temp_error, 0);
    EXPECT_EQ(bench.ask(sam::ReadCurrentPosition{}).position, 20'000);
}

TEST(SamProtection, IsHotUntilItIsCoolerByTheHysteresisItIsBuiltWith)
{
    covers("A.8 5");
    for (const double hysteresis_k : {0.0, 10.0}) {
        auto spec = spec_of("SAM-160");
        spec.device.overheat_hysteresis_k = hysteresis_k;
        Bench<SamDevice> bench(spec);
        const auto hot_at = [&](double temperature_c) {
            bench.device.plant().heat_to(temperature_c);
            bench.run(1ms);
            return bench.ask(sam::ReadTemperatureError{}).temp_error == 1;
        };
        EXPECT_FALSE(hot_at(60.0));
        EXPECT_TRUE(hot_at(65.5));
        EXPECT_EQ(hot_at(60.0), hysteresis_k > 0.0);
        EXPECT_FALSE(hot_at(54.0));
        EXPECT_FALSE(hot_at(60.0));
    }
}

TEST(SamProtection, OrdinaryMovesDoNotTripIt)
{
    for (const sam::Model& model : sam::models()) {
        Bench<SamDevice> bench(spec_of(model.name));
        for (const int target : {250, 4, 250, 4}) {
            bench.ask(sam::QuickPositionControl{.target_position = static_cast<std::uint8_t>(target)});
            for (int k = 0; k < 150; ++k) {
                bench.run(10ms);
                ASSERT_EQ(bench.device.look().faults, "") << model.name;
            }
        }
    }
}

} // namespace
} // namespace sinew::sim
