#include "sinew/family/rmd/driver_for_tests.hpp"

#include <cmath>

/// The position from the encoder.
namespace sinew::rmd::test {
namespace {

/// A motor that turns and answers, as far as the driver asks.
class Turning
{
public:
    explicit Turning(Driver& driver, double encoder_turns_per_turn = 1.0, int sense = 1)
        : driver_(driver), encoder_turns_(encoder_turns_per_turn), sense_(sense)
    {
    }

    /// One turn of a control loop; how many requests it took.
    std::size_t cycle()
    {
        const auto plan = driver_.plan_cycle({.mode = Mode::velocity, .velocity_rad_s = units::rad(speed)}, state);
        EXPECT_TRUE(plan.has_value());
        for (const auto& asked : plan->all()) {
            at += std::chrono::microseconds(500);
            deg += speed * 0.0005;
            answer(asked);
        }
        at += std::chrono::milliseconds(1);
        deg += speed * 0.001;
        return plan->all().size();
    }

    void answer(const wire::Request& asked)
    {
        const double turns = sense_ * deg * encoder_turns_ / 360.0;
        const auto count = static_cast<std::int64_t>(std::llround((turns - std::floor(turns)) * 16384.0));
        const MotorState motor{.speed = static_cast<std::int16_t>(speed),
                               .encoder = static_cast<std::uint16_t>(count % 16384)};
        const auto angle = MultiTurnAngle{std::llround(deg * 100.0)};
        const auto reply =
            asked.message == &wire::info_of<SpeedClosedLoop> ? wire::encode_reply<SpeedClosedLoop>(1, motor)
            : asked.message == &wire::info_of<ReadStatus2>   ? wire::encode_reply<ReadStatus2>(1, motor)
                                                             : wire::encode_reply<ReadMultiTurnAngle>(1, angle);
        truth = deg;
        EXPECT_TRUE(driver_.absorb(asked, *reply, at, state).has_value());
    }

    double deg = 700.0;
    double speed = 90.0;
    double truth = 0.0; ///< when it last answered
    TimePoint at{};
    actuator::State state;

private:
    Driver& driver_;
    double encoder_turns_;
    int sense_;
};

TEST(RmdDriver, ACycleIsOneExchangeOnceTheEncoderHasProvenItself)
{
    for (const int sense : {1, -1}) {
        Driver driver(spec());
        Turning motor(driver, 1.0, sense);
        for (int i = 0; i < 20; ++i)
            EXPECT_EQ(motor.cycle(), 2U) << "five degrees at 90 deg/s take 55 ms";
        for (int i = 0; i < 20; ++i)
            motor.cycle();
        int asked_for_angle = 0;
        for (int i = 0; i < 2000; ++i) {
            if (i == 700)
                motor.speed = -200.0;
            asked_for_angle += motor.cycle() == 2U ? 1 : 0;
            ASSERT_NEAR(units::deg(*motor.state.position_rad), motor.truth, 0.2) << i;
        }
        EXPECT_NEAR(asked_for_angle, 2000.0 / 256.0, 2.0) << "checked now and then";
    }
}

TEST(RmdDriver, NeverTellsAPositionFromAnEncoderThatCountsOtherwise)
{
    for (const double ratio : {4.0, 0.25, 1.0 / 9.0, 1.05}) {
        Driver driver(spec());
        Turning motor(driver, ratio);
        for (int i = 0; i < 500; ++i) {
            ASSERT_EQ(motor.cycle(), 2U) << ratio << ' ' << i;
            ASSERT_NEAR(units::deg(*motor.state.position_rad), motor.truth, 0.006) << "always that which was read";
        }
    }
}

TEST(RmdDriver, AsksForTheAngleAgainAfterAGapInWhichTurnsCannotBeCounted)
{
    Driver driver(spec());
    Turning motor(driver);
    for (int i = 0; i < 60; ++i)
        motor.cycle();
    ASSERT_EQ(motor.cycle(), 1U);
    motor.at += std::chrono::milliseconds(60);
    motor.deg += 300.0;
    const auto before = motor.state.position_rad;
    EXPECT_EQ(motor.cycle(), 1U);
    EXPECT_EQ(motor.state.position_rad, before) << "an old position rather than a wrong one";
    EXPECT_EQ(motor.cycle(), 2U);
    EXPECT_NEAR(units::deg(*motor.state.position_rad), motor.truth, 0.006);
    EXPECT_EQ(motor.cycle(), 1U);
    EXPECT_NEAR(units::deg(*motor.state.position_rad), motor.truth, 0.2);
}

} // namespace
} // namespace sinew::rmd::test
