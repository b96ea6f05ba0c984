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

/// A driver whose device has said that it counts absolutely, or relatively.
Driver told(PositionMode mode = PositionMode::absolute)
{
    Driver driver(spec());
    actuator::State state;
    EXPECT_TRUE(driver.absorb(*wire::make_request(0, RequestPositionModeFeedback{}),
                              *wire::encode_reply<RequestPositionModeFeedback>(0, {.position_mode = mode}), TimePoint{},
                              state));
    return driver;
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
    Driver driver = told();
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
    Driver driver = told();
    EXPECT_EQ(driver.plan({.mode = Mode::release}, {})->all()[0].frame,
              *wire::encode_request(0, SetControlOnOff{.control = Control::off}));
    const auto plan = driver.plan({.mode = Mode::position, .position_rad = 0.5}, {});
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].frame, *wire::encode_request(0, SetControlOnOff{.control = Control::on}));
    EXPECT_EQ(driver.plan({.mode = Mode::position, .position_rad = 0.5}, {})->all().size(), 1U);
}

TEST(NuriDriver, RefusesToMoveADeviceThatCountsRelativelyOrHasNotSaid)
{
    const actuator::Command go{.mode = Mode::position, .position_rad = 0.5};
    EXPECT_EQ(told(PositionMode::relative).plan(go, {}).error().code, Errc::unsupported);
    EXPECT_EQ(Driver(spec()).plan(go, {}).error().code, Errc::unsupported);
}

TEST(NuriDriver, AsksOnceHowTheDeviceCounts)
{
    Driver driver(spec());
    EXPECT_EQ(driver.plan_read(actuator::Depth::motion)->all().size(), 2U);
    EXPECT_EQ(told().plan_read(actuator::Depth::motion)->all().size(), 1U);
}

TEST(NuriDriver, HoldsBySpeedZeroWhereverItIs)
{
    const auto plan = Driver(spec()).plan({.mode = Mode::hold}, {.position_rad = units::rad(2000)});
    ASSERT_TRUE(plan.has_value());
    EXPECT_EQ(plan->all()[0].frame, *wire::encode_request(0, AccelSpeedControl{.speed = 0, .arrival_time = 1}));
}

TEST(NuriDriver, NeverRoundsASpeedUp)
{
    Driver driver = told();
    const auto go = [&](double deg_s) {
        return driver.plan({.mode = Mode::position, .position_rad = 0.5, .velocity_rad_s = units::rad(deg_s)}, {});
    };
    EXPECT_EQ(go(0.1).error().code, Errc::out_of_range); // one unit is 0.6 deg/s
    EXPECT_EQ(go(1.1)->all()[0].frame.data[10], 1);
}

TEST(NuriDriver, RefusesAPositionThatTheFieldCannotCarry)
{
    Driver driver(spec());
    EXPECT_EQ(driver.plan({.mode = Mode::position, .position_rad = units::rad(656)}, {}).error().code,
              Errc::out_of_range);
}

} // namespace
} // namespace sinew::nuri
