#include "sinew/family/sam/driver.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/sam/messages.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace sinew::sam {
namespace {

using actuator::Mode;

Spec spec(std::string_view model, int level = 0)
{
    Spec s{.model = find_model(model), .profile = profiles().front(), .id = 7};
    s.profile.response_level = level;
    return s;
}

actuator::State state_after(Driver& driver, const wire::Request& asked, const wire::Frame& reply)
{
    actuator::State state;
    const auto absorbed = driver.absorb(asked, reply, TimePoint{}, state);
    EXPECT_TRUE(absorbed.has_value()) << (absorbed ? "" : to_sentence(absorbed.error()));
    return state;
}

/// What the driver makes of the answer to an M.
template <class M>
actuator::State read(std::string_view model, const wire::ReplyOf<M>& reply)
{
    Driver driver(spec(model));
    return state_after(driver, *wire::make_request(7, M{}), *wire::encode_reply<M>(7, reply));
}

double deg(const std::optional<double>& rad)
{
    return units::deg(rad.value());
}

TEST(SamDriver, OneQuickUnitIs1_08DegreesFromTheCentre127) // L392, L462
{
    EXPECT_DOUBLE_EQ(deg(read<QuickReadStatus>("SAM-20", {.load = 0, .position = 128}).position_rad), 1.08);
    EXPECT_DOUBLE_EQ(deg(read<QuickReadStatus>("SAM-20", {.load = 0, .position = 127}).position_rad), 0.0);
    const double low = deg(read<QuickReadStatus>("SAM-20", {.load = 0, .position = 1}).position_rad);
    const double high = deg(read<QuickReadStatus>("SAM-20", {.load = 0, .position = 254}).position_rad);
    EXPECT_NEAR(high - low, 273.24, 1e-9); // L462
}

TEST(SamDriver, OneStandardUnitIsThePrintedAngleOfEachModel) // L571-583, L762-765
{
    const auto one = [](std::string_view model, int centre) {
        return deg(read<ReadCurrentPosition>(model, {.position = static_cast<std::uint16_t>(centre + 1)}).position_rad);
    };
    EXPECT_NEAR(one("SAM-5", 2047), 0.083, 1e-12);
    EXPECT_NEAR(one("SAM-20", 2047), 0.083, 1e-12);
    EXPECT_NEAR(one("SAM-28", 2047), 0.083, 1e-12);
    EXPECT_NEAR(one("SAM-160EO200", 14504), 0.01241, 1e-12);
    EXPECT_NEAR(one("SAM-180EO200", 15809), 0.01138, 1e-12);
    EXPECT_NEAR(one("SAM-210EO200", 15154), 0.01187, 1e-12);
}

TEST(SamDriver, OnePreciseUnitIsThePrintedAngleOfEachModel) // L763-765
{
    const auto one = [](std::string_view model, unsigned centre) {
        return deg(read<ReadPrecisePosition>(model, {.position = centre + 1}).position_rad);
    };
    EXPECT_NEAR(one("SAM-160EO200", 101529), 0.001773, 1e-12);
    EXPECT_NEAR(one("SAM-180EO200", 126475), 0.001423, 1e-12);
    EXPECT_NEAR(one("SAM-210EO200", 151546), 0.001187, 1e-12);
}

TEST(SamDriver, OneUnitOfSpeedIsThePrintedOne) // L530-536
{
    const auto one = [](std::string_view model) {
        return deg(read<ReadCurrentSpeed>(model, {.current_speed = 1}).velocity_rad_s);
    };
    EXPECT_NEAR(one("SAM-160EO200"), 0.2216, 1e-12);
    EXPECT_NEAR(one("SAM-180EO200"), 0.1778, 1e-12);
    EXPECT_NEAR(one("SAM-210EO200"), 0.1483, 1e-12);
    EXPECT_NEAR(one("SAM-5"), 8.3, 1e-12);
    EXPECT_NEAR(deg(read<ReadCurrentSpeed>("SAM-5", {.current_speed = -10}).velocity_rad_s), -83.0, 1e-9);
}

TEST(SamDriver, CurrentHasTwoScalesAModel) // L394-396, L563-565
{
    EXPECT_NEAR(*read<QuickReadStatus>("SAM-5", {.load = 100, .position = 127}).current_a, 1.289, 1e-12);
    EXPECT_NEAR(*read<QuickReadStatus>("SAM-28", {.load = 100, .position = 127}).current_a, 1.289, 1e-12);
    EXPECT_NEAR(*read<QuickReadStatus>("SAM-160EO200", {.load = 100, .position = 127}).current_a, 1.6, 1e-12);
    EXPECT_NEAR(*read<ReadCurrentLoad>("SAM-5", {.current_load = 1000}).current_a, 0.81, 1e-12);
    EXPECT_NEAR(*read<ReadCurrentLoad>("SAM-210EO200", {.current_load = 1000}).current_a, 1.0, 1e-12);
}

TEST(SamDriver, VoltageIsTheConverterValueTimesItsScalePlus0_65) // L678-680
{
    EXPECT_NEAR(*read<ReadInputVoltage>("SAM-5", {.input_voltage = 1000}).voltage_v, 1000 * 0.00483 + 0.65, 1e-12);
    EXPECT_NEAR(*read<ReadInputVoltage>("SAM-20", {.input_voltage = 1000}).voltage_v, 1000 * 0.00886 + 0.65, 1e-12);
    EXPECT_NEAR(*read<ReadInputVoltage>("SAM-160EO200", {.input_voltage = 0}).voltage_v, 0.65, 1e-12);
}

TEST(SamDriver, OverheatingIsAFault)
{
    EXPECT_TRUE(read<ReadTemperatureError>("SAM-5", {.temp_error = 1}).faults->has(actuator::Fault::over_temperature));
    EXPECT_FALSE(read<ReadTemperatureError>("SAM-5", {.temp_error = 0}).faults->any());
}

TEST(SamDriver, GoesToAPositionInTheFinestCoordinatesOfTheModel)
{
    Driver pot(spec("SAM-20"));
    const auto coarse = pot.plan({.mode = Mode::position, .position_rad = units::rad(90)}, {});
    ASSERT_TRUE(coarse.has_value());
    ASSERT_EQ(coarse->all().size(), 1U);
    EXPECT_EQ(coarse->all()[0].frame,
              *wire::encode_request(7, PositionControl{.target_position = 2047 + 1084})); // 90 / 0.083
    Driver encoder(spec("SAM-160EO200"));
    const auto fine = encoder.plan({.mode = Mode::position, .position_rad = units::rad(-90)}, {});
    EXPECT_EQ(fine->all()[0].frame,
              *wire::encode_request(7, PrecisePositionControl{.target_position = 101529 - 50761})); // 90 / 0.001773
}

TEST(SamDriver, RefusesAPositionOutsideTheControlRangeAndPlansNothing)
{
    Driver driver(spec("SAM-20"));
    const auto plan = driver.plan({.mode = Mode::position, .position_rad = units::rad(170)}, {});
    ASSERT_FALSE(plan.has_value());
    EXPECT_EQ(plan.error().code, Errc::out_of_range);
    EXPECT_NE(to_sentence(plan.error()).find("170.00 deg"), std::string::npos);
}

TEST(SamDriver, RefusesWhatIsNoNumber)
{
    Driver driver(spec("SAM-20"));
    EXPECT_FALSE(driver.plan({.mode = Mode::position, .position_rad = std::nan("")}, {}).has_value());
    EXPECT_FALSE(driver.plan({.mode = Mode::velocity, .velocity_rad_s = HUGE_VAL}, {}).has_value());
}

TEST(SamDriver, RefusesASpeedForAMoveBecauseTheProtocolHasNone)
{
    Driver driver(spec("SAM-20"));
    const auto plan = driver.plan({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = 1.0}, {});
    EXPECT_EQ(plan.error().code, Errc::unsupported);
}

TEST(SamDriver, HoldsWhereItIsAndNeedsToKnowWhere)
{
    Driver driver(spec("SAM-20"));
    EXPECT_EQ(driver.plan({.mode = Mode::hold}, {}).error().code, Errc::unsupported);
    const auto plan = driver.plan({.mode = Mode::hold}, {.position_rad = units::rad(8.3)});
    EXPECT_EQ(plan->all()[0].frame, *wire::encode_request(7, PositionControl{.target_position = 2147}));
}

TEST(SamDriver, ReleasesByPassiveModeAndTurnsByWheelMode)
{
    Driver driver(spec("SAM-20"));
    EXPECT_EQ(driver.plan({.mode = Mode::release}, {})->all()[0].frame,
              *wire::encode_request(7, SpecialControl{.mode = sam::Mode::passive}));
    const double half = driver.capabilities().velocity_max_rad_s.value() / 2;
    EXPECT_EQ(driver.plan({.mode = Mode::velocity, .velocity_rad_s = half}, {})->all()[0].frame,
              *wire::encode_request(7, SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 500}));
    EXPECT_EQ(driver.plan({.mode = Mode::velocity, .velocity_rad_s = -half}, {})->all()[0].frame,
              *wire::encode_request(7, SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 1500}));
    EXPECT_EQ(driver.plan({.mode = Mode::velocity, .velocity_rad_s = 0.0}, {})->all()[0].frame,
              *wire::encode_request(7, SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = 0}));
}

TEST(SamDriver, WaitsForAnAnswerOnlyWhereTheResponseLevelGivesOne)
{
    const actuator::Command go{.mode = Mode::position, .position_rad = 0.0};
    EXPECT_FALSE(Driver(spec("SAM-20", 0)).plan(go, {})->all()[0].answered);
    EXPECT_TRUE(Driver(spec("SAM-20", 1)).plan(go, {})->all()[0].answered);
    EXPECT_TRUE(Driver(spec("SAM-20", 0)).plan_read(actuator::Depth::motion)->all()[0].answered);
    EXPECT_EQ(Driver(spec("SAM-20", 2)).plan_read(actuator::Depth::motion).error().code, Errc::unsupported);
}

} // namespace
} // namespace sinew::sam
