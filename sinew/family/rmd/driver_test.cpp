#include "sinew/family/rmd/driver.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/rmd/messages.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::rmd {
namespace {

using actuator::Mode;

Spec spec(std::string_view model = "MG", bool confirmed = true)
{
    Profile profile = profiles().front();
    profile.max_speed_confirmed = confirmed;
    return make_spec(*find_model(model), profile, 1);
}

template <class M>
actuator::State read(const wire::ReplyOf<M>& reply, std::string_view model = "MG")
{
    Driver driver(spec(model));
    actuator::State state;
    const auto absorbed =
        driver.absorb(*wire::make_request(1, M{}), *wire::encode_reply<M>(1, reply), TimePoint{}, state);
    EXPECT_TRUE(absorbed.has_value());
    return state;
}

wire::Frame frame(std::array<std::uint8_t, 8> data)
{
    wire::Frame out{.can_id = 0x141, .size = 8};
    std::ranges::copy(data, out.data.begin());
    return out;
}

TEST(RmdDriver, SendsThePrintedSpeed) // L38: 90 dps
{
    const auto plan = Driver(spec()).plan({.mode = Mode::velocity, .velocity_rad_s = units::rad(90)}, {});
    EXPECT_EQ(plan->all()[0].frame, frame({0xA2, 0, 0, 0, 0x28, 0x23, 0, 0}));
}

TEST(RmdDriver, SendsThePrintedMoveWhereTheProfileIsConfirmed) // L43: 720 deg at 90 dps
{
    const actuator::Command go{
        .mode = Mode::position, .position_rad = units::rad(720), .velocity_rad_s = units::rad(90)};
    EXPECT_EQ(Driver(spec()).plan(go, {})->all()[0].frame, frame({0xA4, 0, 0x28, 0x23, 0x40, 0x19, 0x01, 0}));
}

TEST(RmdDriver, SendsTheScaleThatCanOnlyBeSlowWhereNobodyNamedTheProfile) // R01
{
    const actuator::Command go{
        .mode = Mode::position, .position_rad = units::rad(720), .velocity_rad_s = units::rad(90)};
    EXPECT_EQ(Driver(spec("MG", false)).plan(go, {})->all()[0].frame, frame({0xA4, 0, 90, 0, 0x40, 0x19, 0x01, 0}));
}

TEST(RmdDriver, ReadsMultiTurnAnglesBeyond32BitAndBelowZero) // R10
{
    EXPECT_NEAR(units::deg(*read<ReadMultiTurnAngle>({.angle = -3000}).position_rad), -30.0, 1e-9);
    EXPECT_NEAR(units::deg(*read<ReadMultiTurnAngle>({.angle = -10'000'000'000}).position_rad), -1e8, 1e-3);
}

TEST(RmdDriver, FullScaleCurrentIsThatOfTheClass) // L777, L98, R11
{
    EXPECT_NEAR(*read<ReadStatus2>({.iq = 2048}, "MF").current_a, 16.5, 1e-9);
    EXPECT_NEAR(*read<ReadStatus2>({.iq = -2048}, "MG").current_a, -33.0, 1e-9);
    EXPECT_FALSE(read<ReadStatus2>({.iq = 2048}, "RMD").current_a.has_value()) << "no class, no scale";
}

TEST(RmdDriver, ReadsSpeedTemperatureAndVoltage) // L636-654, L548-574
{
    const auto moving = read<ReadStatus2>({.temperature = -5, .iq = 0, .speed = -180});
    EXPECT_NEAR(units::deg(*moving.velocity_rad_s), -180.0, 1e-9);
    EXPECT_EQ(moving.temperature_c, -5.0);
    EXPECT_NEAR(*read<ReadStatus1>({.temperature = 25, .voltage = 241}).voltage_v, 24.1, 1e-9);
}

TEST(RmdDriver, KeepsUnexplainedErrorBitsRaw) // R31
{
    const auto state = read<ReadStatus1>({.temperature = 25, .voltage = 60, .error_state = 0x81});
    EXPECT_TRUE(state.faults->has(actuator::Fault::low_voltage));
    EXPECT_TRUE(state.faults->has(actuator::Fault::unexplained));
    EXPECT_FALSE(state.faults->has(actuator::Fault::over_temperature));
    EXPECT_EQ(state.raw_faults, 0x81U);
}

TEST(RmdDriver, AnAcknowledgementTellsNothingOfTheState)
{
    const auto state = read<MotorOff>({});
    EXPECT_FALSE(state.position_rad || state.velocity_rad_s || state.temperature_c || state.faults);
}

TEST(RmdDriver, SendsRunningAfterOffBeforeItMovesAgain) // R30
{
    Driver driver(spec());
    EXPECT_EQ(driver.plan({.mode = Mode::release}, {})->all()[0].frame, frame({0x80, 0, 0, 0, 0, 0, 0, 0}));
    const auto plan = driver.plan({.mode = Mode::velocity, .velocity_rad_s = 0.0}, {});
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].frame, frame({0x88, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(RmdDriver, PlansStateAndMotionOnEveryFirmwareLine)
{
    for (const auto& profile : profiles()) {
        Driver driver(make_spec(*find_model("MG"), profile, 1));
        const auto works = [&](const auto& plan) {
            EXPECT_TRUE(plan.has_value()) << profile.line.name << ": " << (plan ? "" : to_sentence(plan.error()));
        };
        works(driver.plan_read(actuator::Depth::full));
        works(driver.plan({.mode = Mode::release}, {}));
        works(driver.plan({.mode = Mode::position, .position_rad = 1.0, .velocity_rad_s = 1.0}, {}));
        works(driver.plan({.mode = Mode::velocity, .velocity_rad_s = 1.0}, {}));
    }
}

TEST(RmdDriver, HoldsBySpeedZeroOnEveryLineWhateverItKnows)
{
    for (const auto& profile : profiles()) {
        Driver driver(make_spec(*find_model("MG"), profile, 1));
        const auto plan = driver.plan({.mode = Mode::hold}, {});
        ASSERT_TRUE(plan.has_value()) << profile.line.name;
        const auto& data = plan->all()[0].frame.data;
        EXPECT_EQ(data[0], 0xA2) << profile.line.name;
        EXPECT_EQ(data[4] | data[5] | data[6] | data[7], 0) << profile.line.name;
    }
}

TEST(RmdDriver, NeverRoundsASpeedLimitUp)
{
    Driver slow(spec("MG", false)); // one unit is 1 deg/s
    const auto go = [&](double deg_s) {
        return slow.plan({.mode = Mode::position, .position_rad = 1.0, .velocity_rad_s = units::rad(deg_s)}, {});
    };
    EXPECT_EQ(go(0.2).error().code, Errc::out_of_range);
    EXPECT_EQ(go(70000).error().code, Errc::out_of_range);
    EXPECT_EQ(go(1.9)->all()[0].frame.data[2], 1);
}

TEST(RmdDriver, RunsAMotorThatSaysItIsOffBeforeItMovesIt) // field notes 1: motorState 0x10
{
    const auto* line = std::ranges::find(profiles(), "lk-2.35", [](const Profile& p) { return p.line.name; }).base();
    Driver driver(make_spec(*find_model("MG"), *line, 1));
    const auto read = driver.plan_read(actuator::Depth::full);
    actuator::State state;
    ASSERT_TRUE(driver.absorb(read->all()[2], frame({0x9A, 25, 0, 0, 0, 0, 0x10, 0}), TimePoint{}, state).has_value());
    const auto plan = driver.plan({.mode = Mode::velocity, .velocity_rad_s = 1.0}, {});
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].frame.data[0], 0x88);
    ASSERT_TRUE(driver.absorb(plan->all()[0], plan->all()[0].frame, TimePoint{}, state).has_value());
    EXPECT_EQ(driver.plan({.mode = Mode::velocity, .velocity_rad_s = 1.0}, {})->all().size(), 1U);
}

} // namespace
} // namespace sinew::rmd
