#include "sinew/family/nuri/driver.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/nuri/messages.hpp"

#include <gtest/gtest.h>

namespace sinew::nuri {
namespace {

using actuator::Mode;

Spec spec()
{
    return {.model = find_model("RSA"), .profile = profiles().front(), .id = 0};
}

template <class M>
actuator::State read(const wire::ReplyOf<M>& reply)
{
    Driver driver(spec());
    actuator::State state;
    const auto absorbed =
        driver.absorb(*wire::make_request(0, M{}), *wire::encode_reply<M>(0, reply), TimePoint{}, state);
    EXPECT_TRUE(absorbed.has_value());
    return state;
}

TEST(NuriDriver, ReadsThePrintedPositionFeedback) // L118: CCW 179.84 deg, 0.0 rpm, 0.0 A
{
    const auto state =
        read<RequestPositionFeedback>({.position_direction = Rotation::counter_clockwise, .position = 0x4640});
    EXPECT_NEAR(units::deg(*state.position_rad), 179.84, 1e-9);
    EXPECT_EQ(state.velocity_rad_s, 0.0);
    EXPECT_EQ(state.current_a, 0.0);
}

TEST(NuriDriver, ReadsThePrintedSpeedFeedback) // L125: CCW 10.2 rpm, 3086.2 deg, 0.2 A
{
    const auto state = read<RequestSpeedFeedback>(
        {.speed_direction = Rotation::counter_clockwise, .speed = 0x66, .position = 0x788E, .current = 2});
    EXPECT_NEAR(units::rpm(*state.velocity_rad_s), 10.2, 1e-9);
    EXPECT_NEAR(*state.current_a, 0.2, 1e-12);
    EXPECT_FALSE(state.position_rad.has_value()) << "the sign of the position does not travel here";
}

TEST(NuriDriver, ClockwiseIsNegative)
{
    const auto state = read<RequestPositionFeedback>({.position_direction = Rotation::clockwise, .position = 9000});
    EXPECT_NEAR(units::deg(*state.position_rad), -90.0, 1e-9);
}

TEST(NuriDriver, DoesNotInventTheSignOfASpeed)
{
    const auto state = read<RequestPositionFeedback>({.position = 0, .speed = 50});
    EXPECT_FALSE(state.velocity_rad_s.has_value());
}

TEST(NuriDriver, SendsThePrintedMove) // L8: CCW 180.00 deg at 5.0 rpm
{
    Driver driver(spec());
    const auto plan = driver.plan(
        {.mode = Mode::position, .position_rad = units::rad(180), .velocity_rad_s = units::rad_s_from_rpm(5)}, {});
    const wire::Frame printed{.size = 11, .data = {0xFF, 0xFE, 0, 7, 0x2F, 1, 0, 0x46, 0x50, 0, 0x32}};
    ASSERT_EQ(plan->all().size(), 1U);
    EXPECT_EQ(plan->all()[0].frame, printed);
    EXPECT_FALSE(plan->all()[0].answered);
}

TEST(NuriDriver, SendsThePrintedSpeed) // L22: CCW 10 rpm in 1.0 s
{
    Driver driver(spec());
    const auto plan = driver.plan({.mode = Mode::velocity, .velocity_rad_s = units::rad_s_from_rpm(10)}, {});
    const wire::Frame printed{.size = 10, .data = {0xFF, 0xFE, 0, 6, 0x88, 3, 0, 0, 0x64, 0x0A}};
    EXPECT_EQ(plan->all()[0].frame, printed);
}

TEST(NuriDriver, SwitchesControlOnAgainAfterARelease)
{
    Driver driver(spec());
    EXPECT_EQ(driver.plan({.mode = Mode::release}, {})->all()[0].frame,
              *wire::encode_request(0, SetControlOnOff{.control = Control::off}));
    const auto plan = driver.plan({.mode = Mode::position, .position_rad = 0.5}, {});
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].frame, *wire::encode_request(0, SetControlOnOff{.control = Control::on}));
    EXPECT_EQ(driver.plan({.mode = Mode::position, .position_rad = 0.5}, {})->all().size(), 1U);
}

TEST(NuriDriver, RefusesToMoveADeviceThatCountsRelatively)
{
    Driver driver(spec());
    actuator::State state;
    ASSERT_TRUE(
        driver.absorb(*wire::make_request(0, RequestPositionModeFeedback{}),
                      *wire::encode_reply<RequestPositionModeFeedback>(0, {.position_mode = PositionMode::relative}),
                      TimePoint{}, state));
    EXPECT_EQ(driver.plan({.mode = Mode::position, .position_rad = 0.5}, {}).error().code, Errc::unsupported);
}

TEST(NuriDriver, RefusesAPositionThatTheFieldCannotCarry)
{
    Driver driver(spec());
    EXPECT_EQ(driver.plan({.mode = Mode::position, .position_rad = units::rad(656)}, {}).error().code,
              Errc::out_of_range);
}

} // namespace
} // namespace sinew::nuri
