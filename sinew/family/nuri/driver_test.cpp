#include "sinew/family/nuri/driver.hpp"

#include "sinew/base/units.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "tests/support/allocations.hpp"

#include <cmath>
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

// ---- moves in a time ----

TEST(NuriDriver, SendsThePrintedMoveInATime) // L15: CCW 180.00 deg in 1.0 s
{
    Driver driver = told();
    const auto plan =
        driver.plan({.mode = Mode::position, .position_rad = units::rad(180), .duration = std::chrono::seconds(1)}, {});
    EXPECT_EQ(plan->all()[0].frame,
              *wire::encode_request(0, AccelPositionControl{.position = 18000, .arrival_time = 10}));
}

TEST(NuriDriver, NeverArrivesEarlierThanAsked)
{
    Driver driver = told();
    const auto arrival = [&](int ms) {
        const auto plan =
            driver.plan({.mode = Mode::position, .position_rad = 1.0, .duration = std::chrono::milliseconds(ms)}, {});
        return plan ? plan->all()[0].frame.data[9] : 0;
    };
    EXPECT_EQ(arrival(1), 1);
    EXPECT_EQ(arrival(100), 1);
    EXPECT_EQ(arrival(101), 2);
    EXPECT_EQ(arrival(25'500), 255);
    EXPECT_EQ(arrival(25'501), 0) << "more than the field carries";
}

TEST(NuriDriver, ReachesASpeedInTheTimeThatWasNamed)
{
    Driver driver(spec());
    const auto plan = driver.plan({.mode = Mode::velocity,
                                   .velocity_rad_s = -units::rad_s_from_rpm(10),
                                   .duration = std::chrono::milliseconds(300)},
                                  {});
    EXPECT_EQ(plan->all()[0].frame,
              *wire::encode_request(
                  0, AccelSpeedControl{.speed_direction = Rotation::clockwise, .speed = 100, .arrival_time = 3}));
}

TEST(NuriDriver, SaysWhyItTakesNoCurrentNoDutyAndNoBrake)
{
    Driver driver(spec());
    for (const actuator::Command& command :
         {actuator::Command{.mode = Mode::current, .current_a = 1.0},
          actuator::Command{.mode = Mode::torque, .torque_nm = 1.0}, actuator::Command{.mode = Mode::duty, .duty = 0.1},
          actuator::Command{.mode = Mode::brake}}) {
        const auto plan = driver.plan(command, {});
        ASSERT_FALSE(plan.has_value());
        EXPECT_EQ(plan.error().code, Errc::unsupported);
        EXPECT_NE(to_sentence(plan.error()).find("the protocol has no"), std::string::npos);
    }
}

TEST(NuriDriver, WhatItSendsHasTheSignAndTheMagnitudeOfWhatWasAsked)
{
    for (const bool ccw_positive : {true, false}) {
        Spec turned = spec();
        turned.profile.ccw_positive = ccw_positive;
        Driver driver(turned);
        actuator::State state;
        ASSERT_TRUE(driver.absorb(*wire::make_request(0, RequestPositionModeFeedback{}),
                                  *wire::encode_reply<RequestPositionModeFeedback>(0, {}), TimePoint{}, state));
        for (double deg = -655.3; deg <= 655.3; deg += 3.7) {
            const auto plan = driver.plan({.mode = Mode::position, .position_rad = units::rad(deg)}, {});
            const auto sent = wire::decode_request<PositionSpeedControl>(plan->all()[0].frame)->message;
            const auto said = *wire::encode_reply<RequestPositionFeedback>(
                0, {.position_direction = sent.position_direction, .position = sent.position});
            ASSERT_TRUE(driver.absorb(*wire::make_request(0, RequestPositionFeedback{}), said, TimePoint{}, state));
            EXPECT_NEAR(units::deg(*state.position_rad), deg, 0.005001);
            const bool is_counter_clockwise = sent.position_direction == Rotation::counter_clockwise;
            EXPECT_EQ(is_counter_clockwise, (deg >= 0.0) == ccw_positive);
        }
    }
}

// ---- sign and magnitude ----

TimePoint ms(int count)
{
    return TimePoint{} + std::chrono::milliseconds(count);
}

/// A device that is heard again and again by one driver.
class Listener
{
public:
    explicit Listener(PositionFeedbackLimit limit = PositionFeedbackLimit::clamp) : driver(limited(limit)) {}

    void position(Rotation direction, int raw, int speed, TimePoint at)
    {
        absorb<RequestPositionFeedback>({.position_direction = direction,
                                         .position = static_cast<std::uint16_t>(raw),
                                         .speed = static_cast<std::uint16_t>(speed)},
                                        at);
    }
    void speed(Rotation direction, int speed, int raw, TimePoint at)
    {
        absorb<RequestSpeedFeedback>({.speed_direction = direction,
                                      .speed = static_cast<std::uint16_t>(speed),
                                      .position = static_cast<std::uint16_t>(raw)},
                                     at);
    }
    template <class M>
    void absorb(const wire::ReplyOf<M>& reply, TimePoint at)
    {
        ASSERT_TRUE(driver.absorb(*wire::make_request(0, M{}), *wire::encode_reply<M>(0, reply), at, state));
    }

    Driver driver;
    actuator::State state;

private:
    static Spec limited(PositionFeedbackLimit limit)
    {
        Spec s = spec();
        s.profile.position_feedback_limit = limit;
        return s;
    }
};

constexpr auto ccw = Rotation::counter_clockwise;
constexpr auto cw = Rotation::clockwise;

TEST(NuriDriver, KeepsAnOlderVelocityWithItsOwnTimeWhenPositionFeedbackSaysNoSign)
{
    Listener listener;
    listener.speed(cw, 100, 0, ms(1));
    listener.position(ccw, 1000, 100, ms(5));
    EXPECT_NEAR(units::rpm(*listener.state.velocity_rad_s), -10.0, 1e-9);
    EXPECT_EQ(listener.state.velocity_rad_s.at(), ms(1));
    EXPECT_EQ(listener.state.position_rad.at(), ms(5));
}

TEST(NuriDriver, BeyondTheEndOfPositionFeedbackTheMagnitudeComesFromSpeedFeedback) // N17
{
    Listener listener;
    listener.position(cw, 65533, 100, ms(0));
    EXPECT_FALSE(listener.state.position_rad) << "655.33 deg is an end, not a position";
    listener.speed(ccw, 100, 30862, ms(5));
    EXPECT_NEAR(units::deg(*listener.state.position_rad), -3086.2, 1e-9);
    EXPECT_NEAR(units::rpm(*listener.state.velocity_rad_s), 10.0, 1e-9);
}

TEST(NuriDriver, AsksForSpeedAsWellWhereThePositionIsBeyondTheEnd)
{
    Listener listener;
    listener.absorb<RequestPositionModeFeedback>({}, ms(0));
    EXPECT_EQ(listener.driver.plan_read(actuator::Depth::motion)->all().size(), 1U);
    listener.position(cw, 65533, 100, ms(0));
    EXPECT_EQ(listener.driver.plan_read(actuator::Depth::motion)->all().size(), 2U);
    listener.position(cw, 65000, 100, ms(9));
    EXPECT_EQ(listener.driver.plan_read(actuator::Depth::motion)->all().size(), 1U);
    EXPECT_NEAR(units::deg(*listener.state.position_rad), -650.0, 1e-9);
}

TEST(NuriDriver, TellsNoPositionWhereTheShaftMayHaveComeThroughZeroBetweenTheTwo)
{
    Listener late;
    late.position(cw, 65533, 100, ms(0));
    late.speed(ccw, 100, 8000, ms(501));
    EXPECT_FALSE(late.state.position_rad) << "half a second apart";
    Listener fast;
    fast.position(cw, 65533, 30'000, ms(0)); // 3000 rpm: 18 deg a millisecond
    fast.speed(ccw, 30'000, 7000, ms(30));
    EXPECT_FALSE(fast.state.position_rad) << "it may have turned 1080 deg since, and 700 are told";
    fast.speed(ccw, 30'000, 20'000, ms(30));
    EXPECT_NEAR(units::deg(*fast.state.position_rad), -2000.0, 1e-9);
}

TEST(NuriDriver, PutsAPositionThatStartsAgainTogetherFromBothKindsOfFeedback) // N17: the other reading
{
    Listener listener(PositionFeedbackLimit::wrap);
    listener.position(cw, 1234, 10, ms(0));
    EXPECT_FALSE(listener.state.position_rad) << "12.34 deg, or that beyond one or more ends";
    listener.speed(cw, 10, 6677, ms(2)); // 667.7 deg
    EXPECT_NEAR(units::deg(*listener.state.position_rad), -667.68, 1e-9);
    listener.position(ccw, 1234, 10, ms(4));
    listener.speed(cw, 10, 123, ms(6));
    EXPECT_NEAR(units::deg(*listener.state.position_rad), 12.34, 1e-9);
}

TEST(NuriDriver, CountsTheRoundsWhereEvenSpeedFeedbackStartsAgain) // N17: a position of 0.17 rad was told for 114.6
{
    Listener listener(PositionFeedbackLimit::wrap);
    const auto look = [&](Rotation side, double deg, TimePoint at) {
        listener.position(side, static_cast<int>(std::lround(deg * 100)) % 65534, 600, at);
        listener.speed(side, 600, static_cast<int>(std::lround(deg * 10)) % 65534, at);
    };
    for (const double deg : {6500.0, 6550.0, 6553.3, 6553.4, 6600.0, 6650.0, 6553.4, 6553.2, 6500.0}) {
        look(cw, deg, ms(static_cast<int>(deg)));
        EXPECT_NEAR(units::deg(*listener.state.position_rad), -deg, 1e-9);
    }
    look(ccw, 6553.0, ms(10'000'000));
    EXPECT_NEAR(units::deg(*listener.state.position_rad), 6553.0, 1e-9) << "nobody looked for hours while it turned";
    look(ccw, 6600.0, ms(10'000'100));
    EXPECT_NEAR(units::deg(*listener.state.position_rad), 6600.0, 1e-9);
    ASSERT_TRUE(listener.driver.plan_settings().has_value());
    look(ccw, 10.0, ms(10'000'200));
    EXPECT_NEAR(units::deg(*listener.state.position_rad), 10.0, 1e-9) << "a device that has reset itself starts anew";
}

// ---- resets ----

TEST(NuriDriver, NoticesThatADeviceIsOnAlthoughItSaidItWasOff)
{
    Listener listener;
    ASSERT_TRUE(listener.driver.plan({.mode = Mode::release}, {}).has_value());
    listener.absorb<RequestControlOnOffFeedback>({.control = Control::on}, ms(0));
    EXPECT_EQ(listener.driver.noticed_reset(), "") << "the release may not have come through";
    EXPECT_EQ(listener.state.enabled, true);
    listener.absorb<RequestControlOnOffFeedback>({.control = Control::off}, ms(1));
    EXPECT_EQ(listener.state.enabled, false);
    listener.absorb<RequestControlOnOffFeedback>({.control = Control::on}, ms(2));
    EXPECT_NE(listener.driver.noticed_reset(), "");
    EXPECT_TRUE(listener.driver.plan_settings()->empty());
    EXPECT_EQ(listener.driver.noticed_reset(), "");
}

TEST(NuriDriver, NoticesThatSettingsAreNotWhatTheyWere)
{
    Listener listener;
    listener.absorb<RequestGearRatioFeedback>({.gear_ratio = 50}, ms(0));
    listener.absorb<RequestPositionControllerFeedback>({.position_kp = 9, .position_rated_current = 5}, ms(0));
    listener.absorb<RequestGearRatioFeedback>({.gear_ratio = 50}, ms(1));
    EXPECT_EQ(listener.driver.noticed_reset(), "");
    listener.absorb<RequestGearRatioFeedback>({.gear_ratio = 10}, ms(2));
    EXPECT_NE(listener.driver.noticed_reset(), "");
}

TEST(NuriDriver, AsksTheHeapForNothingInSteadyUse)
{
    Listener listener;
    listener.absorb<RequestPositionModeFeedback>({}, ms(0));
    const auto asked = *wire::make_request(0, RequestPositionFeedback{});
    const auto reply = *wire::encode_reply<RequestPositionFeedback>(0, {.position = 100});
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        const actuator::Command go{.mode = Mode::position, .position_rad = i * 0.001};
        if (!listener.driver.plan_cycle(go, listener.state) || !listener.driver.plan_read(actuator::Depth::full) ||
            !listener.driver.absorb(asked, reply, ms(i), listener.state))
            FAIL() << i;
    }
    EXPECT_EQ(support::allocations(), before);
}

} // namespace
} // namespace sinew::nuri
