#include "sinew/actuator/check.hpp"
#include "sinew/base/units.hpp"
#include "tests/support/allocations.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace sinew::actuator {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint at(Duration since)
{
    return TimePoint{} + since;
}

Capabilities everything()
{
    Capabilities can{.position_low_rad = -1.0, .position_high_rad = 1.0, .velocity_max_rad_s = 5.0};
    for (Ability* one : {&can.velocity, &can.velocity_limit, &can.timed, &can.timed_velocity, &can.brake, &can.current,
                         &can.current_limit, &can.torque, &can.duty})
        *one = able;
    can.duration_max = 10s;
    can.current_max_a = 3.0;
    return can;
}

Errc refused(const Command& command, const Capabilities& can = everything())
{
    const auto fine = check(command, can, 7);
    EXPECT_FALSE(fine.has_value()) << to_word(command.mode);
    if (fine)
        return Errc::stopped;
    EXPECT_EQ(fine.error().id, 7);
    EXPECT_FALSE(fine.error().detail.empty());
    return fine.error().code;
}

void fine(const Command& command, const Capabilities& can = everything())
{
    const auto result = check(command, can, 7);
    EXPECT_TRUE(result.has_value()) << to_word(command.mode) << ": " << (result ? "" : to_sentence(result.error()));
}

// ---- what was measured ----

TEST(Measured, KeepsTheTimeOfItsValue)
{
    State state;
    EXPECT_FALSE(state.position_rad);
    EXPECT_EQ(state.position_rad.age(at(3s)), std::nullopt);
    state.position_rad = {0.5, at(1s)};
    state.velocity_rad_s = {2.0, at(2s)};
    EXPECT_EQ(*state.position_rad, 0.5);
    EXPECT_EQ(state.position_rad.age(at(3s)), 2s);
    EXPECT_EQ(state.velocity_rad_s.age(at(3s)), 1s);
    const std::optional<double> plain = state.position_rad;
    EXPECT_EQ(plain, 0.5);
}

TEST(State, CarriesAPositionOnByTheVelocity)
{
    State state;
    state.position_rad = {1.0, at(1000ms)};
    EXPECT_EQ(state.position_rad_at(at(1000ms)), std::nullopt) << "without a velocity nobody knows";
    state.velocity_rad_s = {-4.0, at(1001ms)};
    EXPECT_DOUBLE_EQ(*state.position_rad_at(at(1000ms)), 1.0);
    EXPECT_DOUBLE_EQ(*state.position_rad_at(at(1010ms)), 0.96);
    EXPECT_DOUBLE_EQ(*state.position_rad_at(at(990ms)), 1.04);
}

TEST(State, DoesNotCarryAPositionFurtherThanAVelocityIsGoodFor)
{
    State state;
    state.position_rad = {1.0, at(1000ms)};
    state.velocity_rad_s = {4.0, at(1000ms)};
    EXPECT_TRUE(state.position_rad_at(at(1100ms)));
    EXPECT_FALSE(state.position_rad_at(at(1101ms)));
    EXPECT_TRUE(state.position_rad_at(at(1101ms), 200ms));
    state.velocity_rad_s = {4.0, at(800ms)};
    EXPECT_FALSE(state.position_rad_at(at(1000ms))) << "an old velocity belongs to another position";
}

TEST(Faults, HaveAWordEach)
{
    for (unsigned bit = 0; bit <= 8; ++bit)
        EXPECT_NE(to_word(static_cast<Fault>(1U << bit)), "?") << bit;
}

// ---- what an actuator can do ----

TEST(Check, PassesEveryModeThatIsWholeAndWithinWhatTheActuatorCanDo)
{
    fine({.mode = Mode::hold});
    fine({.mode = Mode::release});
    fine({.mode = Mode::brake});
    fine({.mode = Mode::position, .position_rad = 1.0});
    fine({.mode = Mode::position, .position_rad = -1.0, .velocity_rad_s = 5.0});
    fine({.mode = Mode::position, .position_rad = 0.0, .duration = 10s, .resolution_rad = 0.1});
    fine({.mode = Mode::velocity, .velocity_rad_s = -5.0, .current_a = 3.0, .duration = 1s});
    fine({.mode = Mode::current, .current_a = -3.0});
    fine({.mode = Mode::torque, .torque_nm = -100.0});
    fine({.mode = Mode::duty, .duty = -1.0});
}

TEST(Check, NamesTheValueThatAModeLacks)
{
    for (const auto& [mode, name] : {std::pair{Mode::position, "position_rad"},
                                     {Mode::velocity, "velocity_rad_s"},
                                     {Mode::current, "current_a"},
                                     {Mode::torque, "torque_nm"},
                                     {Mode::duty, "duty"}}) {
        const auto result = check({.mode = mode}, everything(), 7);
        ASSERT_FALSE(result.has_value());
        EXPECT_EQ(result.error().code, Errc::missing_field);
        EXPECT_NE(to_sentence(result.error()).find(name), std::string::npos) << to_sentence(result.error());
    }
}

TEST(Check, RefusesWhatAModeDoesNotTakeSoThatNothingIsLeftOutInSilence)
{
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .current_a = 1.0}), Errc::unsupported);
    EXPECT_EQ(refused({.mode = Mode::velocity, .position_rad = 0.0, .velocity_rad_s = 1.0}), Errc::unsupported);
    EXPECT_EQ(refused({.mode = Mode::current, .velocity_rad_s = 1.0, .current_a = 1.0}), Errc::unsupported);
    EXPECT_EQ(refused({.mode = Mode::torque, .torque_nm = 1.0, .duty = 0.5}), Errc::unsupported);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = 1.0, .duration = 1s}),
              Errc::bad_argument);
}

TEST(Check, RefusesNumbersThatAreNone)
{
    for (const double none : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(refused({.mode = Mode::position, .position_rad = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .resolution_rad = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::velocity, .velocity_rad_s = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::current, .current_a = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::torque, .torque_nm = none}), Errc::out_of_range);
        EXPECT_EQ(refused({.mode = Mode::duty, .duty = none}), Errc::out_of_range);
    }
}

TEST(Check, NeverRefusesToHoldOrToRelease)
{
    const double none = std::numeric_limits<double>::quiet_NaN();
    for (const Mode mode : {Mode::hold, Mode::release})
        fine({.mode = mode, .position_rad = 1e9, .velocity_rad_s = none, .current_a = none, .duty = 7.0},
             Capabilities{});
}

TEST(Check, RefusesWhatLiesBeyondTheActuator)
{
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 1.001}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = 0.0}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = -1.0}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .duration = 0s}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .duration = 11s}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::position, .position_rad = 0.0, .resolution_rad = 0.0}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::velocity, .velocity_rad_s = -5.1}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::velocity, .velocity_rad_s = 1.0, .current_a = 0.0}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::current, .current_a = 3.1}), Errc::out_of_range);
    EXPECT_EQ(refused({.mode = Mode::duty, .duty = -1.1}), Errc::out_of_range);
}

TEST(Check, SaysWhyAnActuatorCannotDoWhatItCannot)
{
    Capabilities can = everything();
    can.current.why_not = can.brake.why_not = can.timed.why_not = "because of the moon";
    for (const Command& command : {Command{.mode = Mode::current, .current_a = 1.0}, Command{.mode = Mode::brake},
                                   Command{.mode = Mode::position, .position_rad = 0.0, .duration = 1s}}) {
        const auto result = check(command, can, 7);
        ASSERT_FALSE(result.has_value());
        EXPECT_EQ(result.error().code, Errc::unsupported);
        EXPECT_NE(to_sentence(result.error()).find("because of the moon"), std::string::npos);
    }
}

// ---- what its user allows ----

TEST(Limits, HoldForEveryModeThatTheyAreAbout)
{
    const Limits limits{.position_low_rad = -0.5,
                        .position_high_rad = 0.5,
                        .velocity_max_rad_s = 1.0,
                        .current_max_a = 2.0,
                        .torque_max_nm = 3.0,
                        .duty_max = 0.4};
    const auto passes = [&](const Command& command, const State& state = {}) {
        return check(command, limits, state, 7).has_value();
    };
    EXPECT_TRUE(passes({.mode = Mode::position, .position_rad = 0.5}));
    EXPECT_FALSE(passes({.mode = Mode::position, .position_rad = -0.501}));
    EXPECT_FALSE(passes({.mode = Mode::position, .position_rad = 0.0, .velocity_rad_s = 1.1}));
    EXPECT_FALSE(passes({.mode = Mode::velocity, .velocity_rad_s = -1.1}));
    EXPECT_FALSE(passes({.mode = Mode::current, .current_a = -2.1}));
    EXPECT_FALSE(passes({.mode = Mode::torque, .torque_nm = 3.1}));
    EXPECT_FALSE(passes({.mode = Mode::duty, .duty = -0.41}));
    const State far{.position_rad = -0.5};
    EXPECT_TRUE(passes({.mode = Mode::position, .position_rad = 0.5, .duration = 1s}, far));
    EXPECT_FALSE(passes({.mode = Mode::position, .position_rad = 0.5, .duration = 900ms}, far))
        << "the mean speed is a speed";
}

TEST(Limits, OfAStepNeedTheMeasuredPosition)
{
    const Limits limits{.step_max_rad = 0.1};
    const Command go{.mode = Mode::position, .position_rad = 1.0};
    EXPECT_EQ(check(go, limits, {}, 7).error().code, Errc::unsupported);
    EXPECT_TRUE(check(go, limits, State{.position_rad = 0.91}, 7).has_value());
    EXPECT_EQ(check(go, limits, State{.position_rad = 0.89}, 7).error().code, Errc::out_of_range);
}

TEST(Limits, OfTemperatureLeaveTheStopsAlone)
{
    const Limits limits{.temperature_max_c = 60.0};
    const State hot{.temperature_c = 60.0};
    EXPECT_FALSE(check({.mode = Mode::velocity, .velocity_rad_s = 0.1}, limits, hot, 7).has_value());
    for (const Mode stop : {Mode::hold, Mode::release, Mode::brake})
        EXPECT_TRUE(check({.mode = stop}, limits, hot, 7).has_value());
}

TEST(Check, AsksTheHeapForNothingWhereAllIsWell)
{
    const Capabilities can = everything();
    const Limits limits{.position_low_rad = -2.0, .velocity_max_rad_s = 9.0, .step_max_rad = 3.0};
    const State state{.position_rad = 0.0};
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        const Command go{.mode = Mode::position, .position_rad = i * 0.001, .velocity_rad_s = 1.0};
        if (!check(go, can, 7) || !check(go, limits, state, 7))
            FAIL() << i;
    }
    EXPECT_EQ(support::allocations(), before);
}

} // namespace
} // namespace sinew::actuator
