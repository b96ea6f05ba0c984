#include "sinew/family/rmd/driver_for_tests.hpp"

#include <cmath>

/// Run-time settings, and what shows that a motor has lost them or its turns.
namespace sinew::rmd::test {
namespace {

Spec tuned(std::string_view line = "rmd-2.35")
{
    Spec s = on_line(line);
    s.runtime.acceleration_rad_s2 = units::rad(500);
    s.runtime.angle = {100, 50, 7};
    if (line == "gyems-1.62") {
        s.runtime.angle = {100, 50, {}};
        s.runtime.speed = {30, 20, {}};
        s.runtime.current = {10, 11, {}};
    }
    return s;
}

TEST(RmdDriver, SetsAccelerationAndGainsInRamOnly)
{
    Driver driver(tuned());
    const auto settings = driver.plan_settings();
    ASSERT_EQ(settings->all().size(), 2U);
    EXPECT_EQ(settings->all()[0].frame, *wire::encode_request(1, WriteAccelerationRam{.acceleration = 500}));
    EXPECT_EQ(settings->all()[1].frame, frame({0x42, 0x96, 100, 0, 50, 0, 7, 0}));
    Driver gyems(tuned("gyems-1.62"));
    EXPECT_EQ(gyems.plan_settings()->all()[1].frame, frame({0x31, 0, 100, 50, 30, 20, 10, 11}));
    EXPECT_TRUE(Driver(spec()).plan_settings()->empty());
}

TEST(RmdDriver, NoticesThatItsAccelerationOrGainsAreGone)
{
    for (const std::string_view lost : {"acceleration", "gains"}) {
        Driver driver(tuned());
        ASSERT_TRUE(driver.plan_settings().has_value());
        actuator::State state;
        const auto say = [&](std::int32_t acceleration, std::uint8_t kp) {
            const auto check = *driver.plan_reset_check();
            for (const auto& asked : check.all()) {
                const bool is_gains = asked.message == &wire::info_of<ReadParameter>;
                if (!is_gains && asked.message != &wire::info_of<ReadAcceleration>)
                    continue;
                const auto reply = is_gains ? frame({0x40, 0x96, kp, 0, 50, 0, 7, 0})
                                            : *wire::encode_reply<ReadAcceleration>(1, {.acceleration = acceleration});
                ASSERT_TRUE(driver.absorb(asked, reply, ms(0), state));
            }
        };
        say(500, 100);
        EXPECT_EQ(driver.noticed_reset(), "");
        say(lost == "acceleration" ? 0 : 500, lost == "gains" ? 99 : 100);
        EXPECT_NE(driver.noticed_reset(), "") << lost;
        ASSERT_TRUE(driver.plan_settings().has_value());
        EXPECT_EQ(driver.noticed_reset(), "");
    }
}

void say_angle(Driver& driver, double deg, int speed, TimePoint at)
{
    actuator::State state;
    ASSERT_TRUE(driver.absorb(*wire::make_request(1, ReadStatus2{}),
                              *wire::encode_reply<ReadStatus2>(1, {.speed = static_cast<std::int16_t>(speed)}), at,
                              state));
    ASSERT_TRUE(driver.absorb(*wire::make_request(1, ReadMultiTurnAngle{}),
                              *wire::encode_reply<ReadMultiTurnAngle>(1, {.angle = std::llround(deg * 100.0)}), at,
                              state));
}

TEST(RmdDriver, NoticesThatAMotorAtRestHasLostWholeTurns) // R38
{
    Driver driver(spec());
    say_angle(driver, 745.0, 0, ms(0));
    say_angle(driver, 25.3, 0, ms(900));
    EXPECT_NE(driver.noticed_reset(), "");
}

TEST(RmdDriver, DoesNotTakeAMoveForAReset)
{
    Driver sent_back(spec());
    say_angle(sent_back, 720.0, 0, ms(0));
    ASSERT_TRUE(sent_back.plan({.mode = Mode::position, .position_rad = 0.0}, {}).has_value());
    say_angle(sent_back, 0.0, 0, ms(9000));
    EXPECT_EQ(sent_back.noticed_reset(), "");
    Driver turning(spec());
    say_angle(turning, 745.0, 90, ms(0));
    say_angle(turning, 25.0, 90, ms(8000));
    EXPECT_EQ(turning.noticed_reset(), "");
    Driver elsewhere(spec());
    say_angle(elsewhere, 745.0, 0, ms(0));
    say_angle(elsewhere, 50.0, 0, ms(900));
    EXPECT_EQ(elsewhere.noticed_reset(), "");
    say_angle(elsewhere, 770.0, 0, ms(1800));
    EXPECT_EQ(elsewhere.noticed_reset(), "") << "turns are lost, never found";
}

TEST(RmdDriver, NoticesThatAnLkMotorIsOnAlthoughItSaidItWasOff) // field notes 1: on after power-up
{
    Driver driver(on_line("lk-2.35"));
    const auto status = driver.plan_read(actuator::Depth::full)->all()[2];
    actuator::State state;
    const auto say = [&](std::uint8_t motor_state) {
        ASSERT_TRUE(driver.absorb(status, frame({0x9A, 25, 0, 0, 0, 0, motor_state, 0}), ms(0), state));
    };
    ASSERT_TRUE(driver.plan({.mode = Mode::release}, {}).has_value());
    say(0x00);
    EXPECT_EQ(driver.noticed_reset(), "") << "it may take the release one frame late";
    say(0x10);
    EXPECT_EQ(state.enabled, false);
    say(0x00);
    EXPECT_NE(driver.noticed_reset(), "");
    EXPECT_EQ(state.enabled, true);
}

TEST(RmdDriver, SaysOnceThatAnLkMotorLosesTheTurnsThatItHasCountedWhenItIsSwitchedOff) // field notes 1
{
    for (const Mode how : {Mode::release, Mode::brake}) {
        Driver driver(on_line("lk-2.35"));
        say_angle(driver, 745.0, 90, ms(0));
        EXPECT_FALSE(driver.take_lost_count());
        ASSERT_TRUE(driver.plan({.mode = how}, {}));
        EXPECT_TRUE(driver.take_lost_count());
        EXPECT_FALSE(driver.take_lost_count());
        say_angle(driver, 25.0, 0, ms(900));
        EXPECT_EQ(driver.noticed_reset(), "") << "it was asked to";
    }
    Driver other(spec());
    ASSERT_TRUE(other.plan({.mode = Mode::release}, {}));
    EXPECT_FALSE(other.take_lost_count());
}

TEST(RmdDriver, TakesAnLkMotorThatAnotherProgramHasSwitchedOffForOneThatHasLostItsTurns)
{
    Driver driver(on_line("lk-2.35"));
    const auto status = driver.plan_read(actuator::Depth::full)->all()[2];
    actuator::State state;
    for (const bool is_new : {true, false}) {
        ASSERT_TRUE(driver.absorb(status, frame({0x9A, 25, 0, 0, 0, 0, 0x10, 0}), ms(0), state));
        EXPECT_EQ(driver.take_lost_count(), is_new);
    }
}

} // namespace
} // namespace sinew::rmd::test
