#include "sinew/family/rmd/driver_for_tests.hpp"
#include "sinew/wire/values.hpp"
#include "tests/support/allocations.hpp"

#include <cmath>
#include <limits>

/// What is asked of a motor, and what it answers.
namespace sinew::rmd::test {
namespace {

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

TEST(RmdDriver, DrivesWithNothingOnEveryLineAndStaysOn)
{
    for (const Profile& profile : profiles())
        for (const std::string_view model : {"RMD", "MG", "MS"}) {
            Driver driver(make_spec(*find_model(model), profile, 1));
            const auto plan = driver.plan_idle();
            const bool is_unknown = model == "MS" && profile.line.find("torque-open-loop") == nullptr;
            ASSERT_EQ(plan.has_value(), !is_unknown) << profile.line.name << model;
            if (is_unknown)
                continue;
            ASSERT_EQ(plan->all().size(), 1U);
            const auto& bytes = plan->all()[0].frame.data;
            EXPECT_EQ(bytes[0], model == "MS" ? 0xA0 : 0xA1) << profile.line.name;
            EXPECT_EQ(bytes[4] | bytes[5], 0);
            EXPECT_TRUE(driver.plan({.mode = Mode::hold}, {})->all().size() == 1) << "it is on";
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

std::int64_t sent(const std::expected<wire::Requests, Error>& plan, std::string_view field)
{
    EXPECT_TRUE(plan.has_value()) << (plan ? "" : to_sentence(plan.error()));
    if (!plan)
        return -1;
    const auto& asked = plan->all().back();
    const auto values = wire::decode(*asked.message, wire::Direction::request, asked.frame, asked.options);
    return values->values.find(field).value_or(-1);
}

// ---- current and torque ----

TEST(RmdDriver, FullScaleCurrentIsThePrintedNumber) // L777: MF 16.5 A, L98: MG 33 A; L791: 2048
{
    for (const auto& [model, full] : {std::pair{"MF", 16.5}, {"MG", 33.0}, {"RMD-L", 16.5}}) {
        Driver driver(spec(model));
        EXPECT_NEAR(driver.capabilities().current_max_a.value(), full, 1e-12);
        EXPECT_EQ(sent(driver.plan({.mode = Mode::current, .current_a = full}, {}), "iq"), 2048) << model;
        EXPECT_EQ(sent(driver.plan({.mode = Mode::current, .current_a = -full / 2}, {}), "iq"), -1024) << model;
        EXPECT_EQ(driver.plan({.mode = Mode::current, .current_a = full * 1.001}, {}).error().code, Errc::out_of_range);
    }
}

TEST(RmdDriver, SendsTheCurrentsOfOtherLinesInTheirOwnUnits) // field notes 1
{
    Driver gyems(on_line("gyems-1.62"));
    EXPECT_EQ(sent(gyems.plan({.mode = Mode::current, .current_a = 32.0}, {}), "iq_control"), 2000);
    EXPECT_EQ(gyems.plan({.mode = Mode::current, .current_a = 32.1}, {}).error().code, Errc::out_of_range);
    Driver myactuator(on_line("myactuator-3", "RMD"));
    EXPECT_EQ(sent(myactuator.plan({.mode = Mode::current, .current_a = -1.23}, {}), "iq"), -123);
}

TEST(RmdDriver, NeverSendsMoreCurrentThanAsked)
{
    Driver driver(spec("MF"));
    const double lsb = 16.5 / 2048.0;
    EXPECT_EQ(sent(driver.plan({.mode = Mode::current, .current_a = 10.9 * lsb}, {}), "iq"), 10);
    EXPECT_EQ(sent(driver.plan({.mode = Mode::current, .current_a = -10.9 * lsb}, {}), "iq"), -10);
    EXPECT_EQ(sent(driver.plan({.mode = Mode::current, .current_a = 11.0 * lsb}, {}), "iq"), 11);
}

TEST(RmdDriver, TakesATorqueOnlyWhereTheConstantIsKnown)
{
    Driver without(spec("MG"));
    const auto refused = without.plan({.mode = Mode::torque, .torque_nm = 1.0}, {});
    EXPECT_EQ(refused.error().code, Errc::unsupported);
    EXPECT_NE(to_sentence(refused.error()).find("torque_constant_nm_per_a"), std::string::npos);
    Profile known = profiles().front();
    known.torque_constant_nm_per_a = 0.5;
    Driver with(make_spec(*find_model("MG"), known, 1));
    EXPECT_EQ(sent(with.plan({.mode = Mode::torque, .torque_nm = -8.25}, {}), "iq"), -1024); // 16.5 A
    EXPECT_EQ(with.plan({.mode = Mode::torque, .torque_nm = 17.0}, {}).error().code, Errc::out_of_range);
}

TEST(RmdDriver, SaysWhatIsMissingWhereItTakesNoCurrent)
{
    const auto why = [](std::string_view model) {
        return to_sentence(Driver(spec(model)).plan({.mode = Mode::current, .current_a = 1.0}, {}).error());
    };
    EXPECT_NE(why("RMD").find("name it"), std::string::npos);
    EXPECT_NE(why("MS").find("mode duty"), std::string::npos);
    EXPECT_EQ(sent(Driver(spec("MS")).plan({.mode = Mode::duty, .duty = -1.0}, {}), "power"), -850); // L745
    EXPECT_EQ(Driver(spec("MG")).plan({.mode = Mode::duty, .duty = 0.1}, {}).error().code, Errc::unsupported);
}

TEST(RmdDriver, LimitsTheCurrentOfASpeedOnTheLinesThatCan)
{
    const actuator::Command turn{.mode = Mode::velocity, .velocity_rad_s = 1.0, .current_a = 16.5};
    EXPECT_EQ(Driver(spec()).plan(turn, {}).error().code, Errc::unsupported);
    for (const auto& [line, message] :
         {std::pair{"lk-2.35", "speed-closed-loop-torque"}, {"lk-2.36", "speed-closed-loop"}}) {
        Driver driver(on_line(line));
        EXPECT_EQ(sent(driver.plan(turn, {}), "iq"), 1024) << line;
        EXPECT_EQ(driver.plan(turn, {})->all()[0].message->name(), message);
    }
    EXPECT_EQ(sent(Driver(on_line("lk-2.36")).plan({.mode = Mode::velocity, .velocity_rad_s = 1.0}, {}), "iq"), 2048)
        << "without a limit the motor has all it may";
}

// ---- the shaft that is counted, and the output ----

TEST(RmdDriver, AGearBetweenCountedShaftAndOutputScalesEverythingThatTurns)
{
    Profile geared = profiles().front();
    geared.gear_ratio = 9.0;
    geared.max_speed_confirmed = true;
    Driver driver(make_spec(*find_model("MG"), geared, 1));
    const actuator::Command go{
        .mode = Mode::position, .position_rad = units::rad(80), .velocity_rad_s = units::rad(10)};
    EXPECT_EQ(driver.plan(go, {})->all()[0].frame, frame({0xA4, 0, 0x28, 0x23, 0x40, 0x19, 0x01, 0})) << "720, 90";
    EXPECT_EQ(sent(driver.plan({.mode = Mode::velocity, .velocity_rad_s = units::rad(-10)}, {}), "speed"), -9000);
    actuator::State state;
    ASSERT_TRUE(driver.absorb(*wire::make_request(1, ReadMultiTurnAngle{}),
                              *wire::encode_reply<ReadMultiTurnAngle>(1, {.angle = 72000}), ms(0), state));
    ASSERT_TRUE(driver.absorb(*wire::make_request(1, ReadStatus2{}),
                              *wire::encode_reply<ReadStatus2>(1, {.speed = -90}), ms(0), state));
    EXPECT_NEAR(units::deg(*state.position_rad), 80.0, 1e-9);
    EXPECT_NEAR(units::deg(*state.velocity_rad_s), -10.0, 1e-9);
    EXPECT_NEAR(units::deg(driver.capabilities().position_step_rad), 0.01 / 9.0, 1e-12);
}

TEST(RmdDriver, WhatItSendsIsWhatWasAskedToHalfAUnit)
{
    for (const auto& profile : profiles()) {
        Driver driver(make_spec(*find_model("MG"), profile, 1));
        std::int64_t before = std::numeric_limits<std::int64_t>::min();
        for (double deg = -100'000.0; deg < 100'000.0; deg += 777.7777) {
            const actuator::Command go{
                .mode = Mode::position, .position_rad = units::rad(deg), .velocity_rad_s = units::rad(500)};
            const auto raw = sent(driver.plan(go, {}), "angle");
            EXPECT_NEAR(static_cast<double>(raw) * 0.01, deg, 0.0050001) << profile.line.name;
            EXPECT_GT(raw, before) << profile.line.name;
            before = raw;
        }
    }
}

TEST(RmdDriver, ADurationIsSentAsTheSpeedThatCoversTheWay)
{
    Driver driver(spec());
    const actuator::Command go{
        .mode = Mode::position, .position_rad = units::rad(100), .duration = std::chrono::seconds(2)};
    EXPECT_EQ(driver.plan(go, {}).error().code, Errc::unsupported) << "from where?";
    EXPECT_EQ(sent(driver.plan(go, {.position_rad = units::rad(10)}), "max_speed"), 4500); // 45 deg/s of 0.01
    EXPECT_EQ(sent(driver.plan(go, {.position_rad = units::rad(190)}), "max_speed"), 4500);
    EXPECT_EQ(sent(driver.plan(go, {.position_rad = units::rad(100)}), "max_speed"), 1);
    const actuator::Command far{
        .mode = Mode::position, .position_rad = units::rad(10'000), .duration = std::chrono::seconds(1)};
    EXPECT_EQ(driver.plan(far, {.position_rad = 0.0}).error().code, Errc::out_of_range);
}

// ---- off, brake, faults ----

TEST(RmdDriver, TellsAnLkMotorTwiceToGoOff) // field notes 2.1
{
    EXPECT_EQ(Driver(spec()).plan({.mode = Mode::release}, {})->all().size(), 1U);
    const auto plan = Driver(on_line("lk-2.35")).plan({.mode = Mode::release}, {});
    ASSERT_EQ(plan->all().size(), 2U);
    EXPECT_EQ(plan->all()[0].frame, plan->all()[1].frame);
}

TEST(RmdDriver, EngagesABrakeWithoutDriveAndFreesItBeforeTheNextMotion)
{
    Driver driver(on_line("lk-2.35"));
    const auto brake = driver.plan({.mode = Mode::brake}, {});
    ASSERT_EQ(brake->all().size(), 2U);
    EXPECT_EQ(brake->all()[0].frame, frame({0x8C, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(brake->all()[1].frame.data[0], 0x80);
    const auto go = driver.plan({.mode = Mode::velocity, .velocity_rad_s = 1.0}, {});
    ASSERT_EQ(go->all().size(), 3U);
    EXPECT_EQ(go->all()[0].frame.data[0], 0x88);
    EXPECT_EQ(go->all()[1].frame, frame({0x8C, 1, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(Driver(on_line("myactuator-3")).plan({.mode = Mode::brake}, {})->all()[0].frame.data[0], 0x78);
    EXPECT_EQ(Driver(spec()).plan({.mode = Mode::brake}, {}).error().code, Errc::unsupported);
}

TEST(RmdDriver, ExplainsTheEightErrorBitsOfTheLineThatHasThem) // field notes 1: LK V2.36
{
    using actuator::Fault;
    Driver driver(on_line("lk-2.36"));
    const auto read = driver.plan_read(actuator::Depth::full);
    const Fault expected[] = {Fault::low_voltage,
                              Fault::high_voltage,
                              Fault::driver_over_temperature,
                              Fault::over_temperature,
                              Fault::over_current,
                              Fault::short_circuit,
                              Fault::stall,
                              Fault::input_lost};
    for (unsigned bit = 0; bit < 8; ++bit) {
        actuator::State state;
        auto reply = frame({0x9A, 25, 0, 0, 0, 0, 0, static_cast<std::uint8_t>(1U << bit)});
        reply.can_id = 0x181;
        ASSERT_TRUE(driver.absorb(read->all()[2], reply, ms(0), state)) << bit;
        EXPECT_EQ(state.faults->bits, static_cast<std::uint16_t>(expected[bit])) << bit;
    }
}

TEST(RmdDriver, AsksTheHeapForNothingInSteadyUse)
{
    Driver driver(spec());
    actuator::State state;
    const auto reply = *wire::encode_reply<TorqueClosedLoop>(1, {.encoder = 5});
    const auto before = support::allocations();
    for (int i = 0; i < 1000; ++i) {
        const auto cycle = driver.plan_cycle({.mode = Mode::current, .current_a = i * 0.01}, state);
        const auto read = driver.plan_read(actuator::Depth::full);
        if (!cycle || !read || !driver.absorb(cycle->all()[0], reply, ms(i), state))
            FAIL() << i;
    }
    EXPECT_EQ(support::allocations(), before);
}

} // namespace
} // namespace sinew::rmd::test
