#include "sinew/family/sam/driver.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/wire/values.hpp"
#include "tests/support/allocations.hpp"

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
    const double half = find_model("SAM-20")->ratings.max_speed_rad_s / 2;
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

// ---- the shortest message that will do ----

actuator::Command go_to(double deg, std::optional<double> resolution_deg = {})
{
    actuator::Command go{.mode = Mode::position, .position_rad = units::rad(deg)};
    if (resolution_deg)
        go.resolution_rad = units::rad(*resolution_deg);
    return go;
}

std::string_view sends(Driver& driver, const actuator::Command& command)
{
    const auto plan = driver.plan(command, {});
    EXPECT_TRUE(plan.has_value()) << (plan ? "" : to_sentence(plan.error()));
    return plan ? plan->all()[0].message->name() : "";
}

TEST(SamDriver, SendsTheShortestMessageThatIsFineEnough)
{
    Driver driver(spec("SAM-160EO200"));
    EXPECT_EQ(sends(driver, go_to(20)), "precise-position-control");
    EXPECT_EQ(sends(driver, go_to(20, 0.01)), "precise-position-control");
    EXPECT_EQ(sends(driver, go_to(20, 0.02)), "position-control");
    EXPECT_EQ(sends(driver, go_to(20, 1.0)), "position-control");
    EXPECT_EQ(sends(driver, go_to(20, 1.1)), "quick-position-control");
    EXPECT_EQ(driver.plan(go_to(21.6, 2.0), {})->all()[0].frame,
              *wire::encode_request(7, QuickPositionControl{.target_position = 147})); // 127 + 20
}

TEST(SamDriver, SendsNoQuickMessageToAnIdOrAPositionThatItDoesNotReach) // L306, L758
{
    Driver near(spec("SAM-20"));
    EXPECT_EQ(sends(near, go_to(137, 2.0)), "quick-position-control");
    EXPECT_EQ(sends(near, go_to(140, 2.0)), "position-control");
    EXPECT_EQ(sends(near, go_to(-140, 2.0)), "position-control");
    for (const auto& [id, message] : {std::pair{30, "quick-position-control"}, {31, "position-control"}}) {
        Spec one = spec("SAM-20");
        one.id = id;
        Driver driver(one);
        EXPECT_EQ(sends(driver, go_to(0, 2.0)), message) << id;
        EXPECT_EQ(driver.plan_read(actuator::Depth::motion, units::rad(2))->all()[0].message->name(),
                  id == 30 ? "quick-read-status" : "read-current-position");
    }
}

TEST(SamDriver, WhatItSendsLiesWithinHalfAStepOfWhatWasAsked)
{
    for (const auto& model : models())
        for (const double resolution_deg : {0.0001, 0.05, 0.1, 1.2}) {
            Driver driver(spec(model.name));
            std::int64_t before = -1;
            for (double deg = -165.0; deg <= 165.0; deg += 0.37) {
                const auto plan = driver.plan(go_to(deg, resolution_deg), {});
                ASSERT_TRUE(plan.has_value()) << model.name << ' ' << deg;
                const auto& asked = plan->all()[0];
                const auto values = wire::decode(*asked.message, wire::Direction::request, asked.frame);
                const auto raw = *values->values.find("target_position");
                const bool quick = asked.message->name() == "quick-position-control";
                const bool precise = asked.message->name() == "precise-position-control";
                const PositionScale& scale = quick ? model.quick : precise ? *model.precise : model.standard;
                EXPECT_NEAR(units::deg(scale.rad(static_cast<double>(raw))), deg, scale.deg_per_unit * 0.5000001)
                    << model.name;
                if (resolution_deg < 0.01) {
                    EXPECT_GT(raw, before) << model.name << ": more degrees are more steps";
                }
                before = raw;
            }
        }
}

TEST(SamDriver, ACycleIsOneExchangeWhereTheCommandIsAnswered)
{
    Driver talks(spec("SAM-160EO200", 1));
    EXPECT_EQ(talks.plan_cycle(go_to(20), {})->all().size(), 1U);
    EXPECT_EQ(talks.plan_cycle({.mode = Mode::duty, .duty = 0.1}, {})->all().size(), 2U) << "says no position";
    Driver obeys(spec("SAM-160EO200", 0));
    const auto cycle = obeys.plan_cycle(go_to(20, 2.0), {});
    ASSERT_EQ(cycle->all().size(), 2U);
    EXPECT_EQ(cycle->all()[1].message->name(), "quick-read-status");
    EXPECT_EQ(Driver(spec("SAM-20", 2)).plan_cycle(go_to(20), {}).error().code, Errc::unsupported);
}

TEST(SamDriver, TakesTheAnswerToACommandForAState) // L736
{
    Driver driver(spec("SAM-20", 1));
    actuator::State state;
    const auto when = TimePoint{} + std::chrono::seconds(5);
    const auto plan = driver.plan(go_to(20, 2.0), {});
    const auto reply = *wire::encode_reply<QuickPositionControl>(7, {.load = 100, .position = 128});
    ASSERT_TRUE(driver.absorb(plan->all()[0], reply, when, state).has_value());
    EXPECT_NEAR(deg(state.position_rad), 1.08, 1e-9);
    EXPECT_NEAR(*state.current_a, 1.289, 1e-12);
    EXPECT_EQ(state.position_rad.at(), when);
    EXPECT_EQ(state.at, when);
    EXPECT_FALSE(state.velocity_rad_s) << "nothing but what was measured";
}

TEST(SamDriver, EveryValueKeepsTheTimeOfItsOwnAnswer)
{
    Driver driver(spec("SAM-20"));
    actuator::State state;
    const auto read = *driver.plan_read(actuator::Depth::full);
    const auto ms = [](int count) { return TimePoint{} + std::chrono::milliseconds(count); };
    ASSERT_TRUE(driver.absorb(read.all()[0], *wire::encode_reply<ReadCurrentPosition>(7, {}), ms(1), state));
    ASSERT_TRUE(driver.absorb(read.all()[1], *wire::encode_reply<ReadCurrentSpeed>(7, {}), ms(2), state));
    ASSERT_TRUE(driver.absorb(read.all()[0], *wire::encode_reply<ReadCurrentPosition>(7, {}), ms(9), state));
    EXPECT_EQ(state.position_rad.at(), ms(9));
    EXPECT_EQ(state.velocity_rad_s.at(), ms(2));
    EXPECT_EQ(state.at, ms(9));
}

// ---- duty, brake, and what it cannot do ----

TEST(SamDriver, DutyIsATenthOfAPerCentAUnitAndCounterClockwiseBeginsAt1000) // L724-728
{
    Driver driver(spec("SAM-20"));
    const auto wheel = [&](double duty) { return driver.plan({.mode = Mode::duty, .duty = duty}, {})->all()[0].frame; };
    const auto frame = [](int speed) {
        return *wire::encode_request(
            7, SpecialControl{.mode = sam::Mode::wheel, .wheel_speed = static_cast<std::uint16_t>(speed)});
    };
    EXPECT_EQ(wheel(0.25), frame(250));
    EXPECT_EQ(wheel(-0.25), frame(1250));
    EXPECT_EQ(wheel(0.0), frame(0));
    EXPECT_EQ(wheel(0.999), frame(999));
    EXPECT_EQ(wheel(-0.999), frame(1999));
    EXPECT_EQ(driver.plan({.mode = Mode::duty, .duty = 1.0}, {}).error().code, Errc::out_of_range);
}

TEST(SamDriver, BrakesOneDeviceAndNotTheLine) // S25
{
    Driver driver(spec("SAM-20"));
    EXPECT_EQ(driver.plan({.mode = Mode::brake}, {})->all()[0].frame,
              *wire::encode_request(7, SpecialControl{.mode = sam::Mode::brake}));
}

TEST(SamDriver, SaysWhyItTakesNoCurrentNoTorqueAndNoDuration)
{
    Driver driver(spec("SAM-20"));
    for (const actuator::Command& command :
         {actuator::Command{.mode = Mode::current, .current_a = 1.0},
          actuator::Command{.mode = Mode::torque, .torque_nm = 1.0},
          actuator::Command{.mode = Mode::position, .position_rad = 0.0, .duration = std::chrono::seconds(1)}}) {
        const auto plan = driver.plan(command, {});
        ASSERT_FALSE(plan.has_value());
        EXPECT_EQ(plan.error().code, Errc::unsupported);
        EXPECT_EQ(plan.error().id, 7);
        EXPECT_NE(to_sentence(plan.error()).find("the protocol has no"), std::string::npos)
            << to_sentence(plan.error());
    }
}

// ---- run-time settings ----

Spec tuned()
{
    Spec s = spec("SAM-20", 1);
    s.runtime = {.p_gain = 40, .d_gain = 8, .i_gain = 3};
    return s;
}

void say_gains(Driver& driver, std::uint8_t p, std::uint8_t d, std::uint8_t i)
{
    actuator::State state;
    const auto check = *driver.plan_reset_check();
    ASSERT_EQ(check.all().size(), 2U);
    ASSERT_TRUE(driver.absorb(check.all()[0], *wire::encode_reply<ReadPdGain>(7, {p, d}), TimePoint{}, state));
    ASSERT_TRUE(driver.absorb(check.all()[1], *wire::encode_reply<ReadIGain>(7, {i}), TimePoint{}, state));
}

TEST(SamDriver, SetsItsGainsForTheRunTimeOnly)
{
    Driver driver(tuned());
    const auto settings = driver.plan_settings();
    ASSERT_EQ(settings->all().size(), 2U);
    EXPECT_EQ(settings->all()[0].frame, *wire::encode_request(7, SetRuntimePdGain{.p_gain = 40, .d_gain = 8}));
    EXPECT_EQ(settings->all()[1].frame, *wire::encode_request(7, SetRuntimeIGain{.i_gain = 3}));
    EXPECT_TRUE(Driver(spec("SAM-20")).plan_settings()->empty());
    EXPECT_TRUE(Driver(spec("SAM-20")).plan_reset_check()->empty()) << "nothing to tell a reset by";
}

TEST(SamDriver, NoticesThatItsGainsAreGoneAndLooksAnewOnceTheyAreSetAgain)
{
    Driver driver(tuned());
    ASSERT_TRUE(driver.plan_settings().has_value());
    say_gains(driver, 40, 8, 3);
    EXPECT_EQ(driver.noticed_reset(), "");
    say_gains(driver, 20, 10, 3);
    EXPECT_NE(driver.noticed_reset(), "");
    ASSERT_EQ(driver.plan_settings()->all().size(), 2U);
    EXPECT_EQ(driver.noticed_reset(), "");
    say_gains(driver, 40, 8, 4);
    EXPECT_NE(driver.noticed_reset(), "");
}

TEST(SamDriver, AsksTheHeapForNothingInSteadyUse)
{
    Driver driver(spec("SAM-160EO200", 1));
    actuator::State state;
    const auto reply = *wire::encode_reply<PrecisePositionControl>(7, {.position = 101529});
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        const auto cycle = driver.plan_cycle(go_to(i * 0.01), state);
        const auto read = driver.plan_read(actuator::Depth::full);
        if (!cycle || !read || !driver.absorb(cycle->all()[0], reply, TimePoint{}, state))
            FAIL() << i;
    }
    EXPECT_EQ(support::allocations(), before);
}

} // namespace
} // namespace sinew::sam
