#include "sinew/sim/firmware/rmd_device.hpp"

#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace sinew::sim {
namespace {

using test::covers;

using namespace std::chrono_literals;
using RmdBench = Bench<RmdDevice>;
using rmd::ParameterId;

rmd::Spec spec_of(std::string_view line = "rmd-2.35", std::string_view model = "MF", int id = 2,
                  const rmd::DeviceOptions& device = {})
{
    for (const rmd::Profile& profile : rmd::profiles())
        if (profile.line.name == line)
            return rmd::make_spec(*rmd::find_model(model), profile, id, device);
    ADD_FAILURE() << "no line " << line;
    return {};
}

TEST(RmdDevice, AnswersEveryMessageOfEveryLineWithOneFrame)
{
    covers("C 1");
    for (const rmd::Profile& profile : rmd::profiles())
        for (const auto* message : profile.line.messages) {
            const rmd::Spec spec = spec_of(profile.line.name);
            const wire::Options options = spec.profile.options();
            RmdBench bench(spec);
            const std::string what = std::string(profile.line.name) + " " + std::string(message->name());
            const auto frame = wire::encode(*message, wire::Direction::request, 2, sample_values(*message, options));
            ASSERT_TRUE(frame) << what;
            const auto answer = bench.device.hear(*frame, bench.now);
            EXPECT_EQ(answer.has_value(), message->reply.exists()) << what;
            if (!answer)
                continue;
            EXPECT_EQ(answer->frame.can_id, profile.reply_identifier_base + 2) << what;
            EXPECT_LE(answer->delay, 250us) << what;
            EXPECT_TRUE(wire::decode(*message, wire::Direction::reply, answer->frame, options)) << what;
        }
    EXPECT_EQ(rmd::manual_messages.size(), 28U);
}

TEST(RmdDevice, IsSilentAboutAnUnknownCommandAnotherIdAndAFrameThatIsNotEightBytesLong)
{
    covers("C 19");
    RmdBench bench(spec_of());
    EXPECT_FALSE(bench.device.hear({.can_id = 0x142, .size = 8, .data = {0x77}}, bench.now));
    EXPECT_FALSE(bench.device.hear({.can_id = 0x143, .size = 8, .data = {0x9A}}, bench.now));
    EXPECT_FALSE(bench.device.hear({.can_id = 0x142, .size = 7, .data = {0x9A}}, bench.now));
    EXPECT_TRUE(bench.device.hear({.can_id = 0x142, .size = 8, .data = {0x9A}}, bench.now));
}

TEST(RmdDevice, AnswersClearErrorAsItsProfileSays)
{
    covers("C 10");
    auto spec = spec_of();
    EXPECT_EQ(RmdBench(spec).send(rmd::ClearError{})->frame.data[0], 0x9A);
    spec.profile.clear_error_reply = rmd::ClearErrorReply::own_9b;
    EXPECT_EQ(RmdBench(spec).send(rmd::ClearError{})->frame.data[0], 0x9B);
}

TEST(RmdDevice, OfTheFirstFourIdsHearsTheMultiMotorFrame)
{
    covers("C 16");
    const rmd::MultiMotorTorque message{.iq_1 = 0, .iq_2 = 500, .iq_3 = 0, .iq_4 = 0};
    RmdBench second(spec_of());
    const auto answer = second.send(message);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->frame.can_id, 0x142U);
    EXPECT_EQ(answer->frame.data[0], 0xA1);
    second.run(10ms);
    EXPECT_GT(second.device.look().velocity_rad_s, 0.0);
    EXPECT_FALSE(RmdBench(spec_of("rmd-2.35", "MF", 5)).send(message));
    EXPECT_FALSE(RmdBench(spec_of("rmd-2.35", "MF", 2, {.multi_motor = false})).send(message));
}

// ---- memory ----

TEST(RmdDevice, ForgetsRamParametersAtPowerOffAndKeepsRomOnes)
{
    covers("C 4");
    RmdBench bench(spec_of());
    const auto angle_pid = bench.ask(rmd::ReadParameter{ParameterId::angle_pid}).value;
    bench.ask(rmd::WriteParameterRam{ParameterId::angle_pid, 0x0003'0002'0001});
    bench.ask(rmd::WriteParameterRom{ParameterId::speed_pid, 0x0006'0005'0004});
    bench.ask(rmd::WriteAccelerationRam{1234});
    EXPECT_EQ(bench.ask(rmd::ReadParameter{ParameterId::angle_pid}).value, 0x0003'0002'0001U);
    EXPECT_EQ(bench.ask(rmd::ReadAcceleration{}).acceleration, 1234);
    EXPECT_EQ(bench.device.flash_writes(), 1U);
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(rmd::ReadParameter{ParameterId::angle_pid}).value, angle_pid);
    EXPECT_EQ(bench.ask(rmd::ReadParameter{ParameterId::speed_pid}).value, 0x0006'0005'0004U);
    EXPECT_EQ(bench.ask(rmd::ReadAcceleration{}).acceleration, 10'000);
}

TEST(RmdDevice, KeepsAllNineParametersApart)
{
    covers("C 4");
    RmdBench bench(spec_of());
    for (const auto& variant : rmd::parameters)
        bench.ask(rmd::WriteParameterRam{static_cast<ParameterId>(variant.selector),
                                         static_cast<std::uint64_t>(variant.selector)});
    for (const auto& variant : rmd::parameters)
        EXPECT_EQ(bench.ask(rmd::ReadParameter{static_cast<ParameterId>(variant.selector)}).value,
                  static_cast<std::uint64_t>(variant.selector));
}

TEST(RmdDevice, KeepsGainsOfTheOldLineInTheirBytes)
{
    RmdBench bench(spec_of("gyems-1.62"));
    bench.ask(rmd::gyems::WritePidRom{1, 2, 3, 4, 5, 6});
    bench.ask(rmd::gyems::WritePidRam{9, 9, 9, 9, 9, 9});
    EXPECT_EQ(bench.ask(rmd::gyems::ReadPid{}).current_ki, 9);
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(rmd::gyems::ReadPid{}).speed_kp, 3);
}

// ---- angles ----

TEST(RmdAngles, CountTurnsAndLoseThemAtPowerOff)
{
    covers("C 9");
    RmdBench bench(spec_of());
    bench.ask(rmd::MultiLoopAngle{.angle = -100'000});
    bench.run(10s);
    // One unit is 0.01 deg, and the shaft rests a little beside its target.
    EXPECT_NEAR(static_cast<double>(bench.ask(rmd::ReadMultiTurnAngle{}).angle), -100'000, 1);
    EXPECT_NEAR(bench.ask(rmd::ReadSingleTurnAngle{}).circle_angle, 8'000, 1);
    bench.device.power_cycle();
    EXPECT_NEAR(static_cast<double>(bench.ask(rmd::ReadMultiTurnAngle{}).angle), 8'000, 1);
}

TEST(RmdAngles, EncoderHasTheBitsOfItsProfile)
{
    for (const int bits : {14, 16, 18}) {
        auto spec = spec_of("rmd-2.35", "MF", 2, {.start_rad = units::rad(90.0)});
        spec.profile.encoder_bits = bits;
        RmdBench bench(spec);
        const int quarter = bits == 14 ? 4096 : 16'384;
        EXPECT_EQ(bench.ask(rmd::ReadEncoder{}).encoder, quarter) << bits;
        EXPECT_EQ(bench.ask(rmd::ReadStatus2{}).encoder, quarter) << bits;
    }
}

TEST(RmdAngles, EncoderOffsetCountsAtOnceOrAtPowerOn)
{
    covers("C 6");
    for (const auto effect : {rmd::OffsetEffect::at_once, rmd::OffsetEffect::at_power_on}) {
        const bool at_once = effect == rmd::OffsetEffect::at_once;
        RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.encoder_offset_effect = effect, .start_rad = units::rad(90.0)}));
        EXPECT_EQ(bench.ask(rmd::WriteEncoderOffset{.encoder_offset = 5000}).encoder_offset, 5000);
        EXPECT_EQ(bench.ask(rmd::ReadEncoder{}).encoder, at_once ? 16'384 + 4096 - 5000 : 4096);
        bench.device.power_cycle();
        const auto encoder = bench.ask(rmd::ReadEncoder{});
        EXPECT_EQ(encoder.encoder, 16'384 + 4096 - 5000);
        EXPECT_EQ(encoder.encoder_raw, 4096);
        EXPECT_EQ(encoder.encoder_offset, 5000);
    }
}

TEST(RmdAngles, ZeroInRomCountsOnlyAfterAPowerCycle)
{
    covers("C 7");
    RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.start_rad = units::rad(90.0)}));
    EXPECT_EQ(bench.ask(rmd::WriteCurrentPositionZeroRom{}).encoder_offset, 4096);
    EXPECT_EQ(bench.ask(rmd::ReadSingleTurnAngle{}).circle_angle, 9'000);
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(rmd::ReadSingleTurnAngle{}).circle_angle, 0);
    EXPECT_EQ(bench.ask(rmd::ReadMultiTurnAngle{}).angle, 0);
}

TEST(RmdAngles, ZeroInRamIsGoneAfterAPowerCycle)
{
    covers("C 8");
    RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.start_rad = units::rad(90.0)}));
    bench.ask(rmd::SetCurrentPositionZero{});
    EXPECT_EQ(bench.ask(rmd::ReadSingleTurnAngle{}).circle_angle, 0);
    EXPECT_EQ(bench.ask(rmd::ReadMultiTurnAngle{}).angle, 0);
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(rmd::ReadMultiTurnAngle{}).angle, 9'000);
}

TEST(RmdAngles, PresentPositionCanBeCalledAnyAngle)
{
    RmdBench bench(spec_of("lk-2.35"));
    bench.ask(rmd::lk::SetCurrentAngle{.angle = -12'345});
    EXPECT_EQ(bench.ask(rmd::ReadMultiTurnAngle{}).angle, -12'345);
}

// ---- states ----

TEST(RmdStates, TellVoltageInTheScaleOfTheLine)
{
    EXPECT_EQ(RmdBench(spec_of()).ask(rmd::ReadStatus1{}).voltage, 240);
    EXPECT_EQ(RmdBench(spec_of("lk-2.35")).ask(rmd::lk::ReadStatus1{}).voltage, 2400);
    EXPECT_EQ(RmdBench(spec_of("myactuator-3")).ask(rmd::myactuator::ReadStatus1{}).voltage, 240);
}

TEST(RmdStates, ShowFaultsWhileTheirCauseLasts)
{
    covers("C 10");
    RmdBench low(spec_of("rmd-2.35", "MF", 2, {.supply_v = 6.5}));
    EXPECT_EQ(low.ask(rmd::ReadStatus1{}).error_state, 1);
    EXPECT_EQ(low.ask(rmd::ClearError{}).error_state, 1);
    RmdBench hot(spec_of("rmd-2.35", "MF", 2, {.temperature_c = 101.0}));
    EXPECT_EQ(hot.ask(rmd::ReadStatus1{}).error_state, 8);
    EXPECT_EQ(hot.ask(rmd::ReadStatus1{}).temperature, 101);
}

TEST(RmdStates, TellWhetherTheMotorIsOnWhereTheLineDoes)
{
    RmdBench bench(spec_of("lk-2.35"));
    EXPECT_EQ(bench.ask(rmd::lk::ReadStatus1{}).motor_state, 0x00);
    bench.ask(rmd::MotorOff{});
    EXPECT_EQ(bench.ask(rmd::lk::ReadStatus1{}).motor_state, 0x10);
}

TEST(RmdStates, TellCurrentsInTheScaleOfModelAndLine)
{
    covers("C 11");
    RmdBench mf(spec_of("rmd-2.35", "MF"));
    RmdBench mg(spec_of("rmd-2.35", "MG"));
    RmdBench x(spec_of("myactuator-3", "MG"));
    mf.ask(rmd::TorqueClosedLoop{.iq = 124}); // 1 A, 2 A and 1 A: what the supply can give
    mg.ask(rmd::TorqueClosedLoop{.iq = 124});
    x.ask(rmd::myactuator::TorqueClosedLoop{.iq = 100});
    for (RmdBench* bench : {&mf, &mg, &x})
        bench->run(2ms);
    EXPECT_EQ(mf.ask(rmd::ReadStatus2{}).iq, 124);
    EXPECT_EQ(mf.ask(rmd::ReadStatus3{}).phase_a_current, std::lround(124 * 16.5 / 2048 * 64));
    EXPECT_EQ(mg.ask(rmd::ReadStatus2{}).iq, 124);
    EXPECT_EQ(mg.ask(rmd::ReadStatus3{}).phase_a_current, std::lround(124 * 33.0 / 2048 * 64));
    EXPECT_EQ(x.ask(rmd::myactuator::ReadStatus2{}).iq, 100);
}

TEST(RmdStates, ASecondLookDoesNotClearAFaultButTheCommandDoesOnceItsCauseIsGone)
{
    covers("C 10");
    RmdBench bench(spec_of());
    bench.supply(6.5);
    bench.run(2ms);
    bench.supply(24.0);
    bench.run(2ms);
    EXPECT_EQ(bench.ask(rmd::ReadStatus1{}).error_state, 1);
    EXPECT_EQ(bench.device.look().faults, "low voltage");
    EXPECT_EQ(bench.ask(rmd::ClearError{}).error_state, 0);
    EXPECT_EQ(bench.device.look().faults, "");
}

TEST(RmdStates, HaveTheLimitsOfTheSettingTool)
{
    covers("C 18");
    const rmd::DeviceOptions tool;
    EXPECT_EQ(tool.temperature_limit_c, 100.0);
    EXPECT_EQ(tool.low_voltage_v, 7.0);
    EXPECT_EQ(tool.over_voltage_v, 26.0);
    RmdBench high(spec_of("lk-2.36", "MF", 2, {.supply_v = 26.5}));
    EXPECT_EQ(high.ask(rmd::lk_2_36::ReadStatus1{}).error_state, 2);
    // The manual has no bit for it (L567-574).
    RmdBench manual(spec_of("rmd-2.35", "MF", 2, {.supply_v = 26.5}));
    EXPECT_EQ(manual.ask(rmd::ReadStatus1{}).error_state, 0);
    EXPECT_EQ(manual.device.look().faults, "high voltage");
}

TEST(RmdStates, AHotMotorStopsUntilItIsCoolAndClearedUnlessBuiltNotTo)
{
    covers("C 18");
    for (const bool stops : {true, false}) {
        RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.stops_on_fault = stops}));
        bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
        bench.run(500ms);
        bench.device.plant().heat_to(120.0);
        bench.run(3s);
        EXPECT_EQ(bench.device.look().velocity_rad_s == 0.0, stops);
        EXPECT_EQ(bench.ask(rmd::ClearError{}).error_state, 8);
        bench.device.plant().heat_to(40.0);
        bench.ask(rmd::ClearError{});
        bench.ask(rmd::SpeedClosedLoop{.speed = 36'000});
        bench.run(500ms);
        EXPECT_GT(bench.device.look().velocity_rad_s, 6.0);
    }
}

TEST(RmdDevice, TakesItsIdFromTheSwitchesOfItsBoard)
{
    covers("C 2");
    RmdBench bench(spec_of());
    EXPECT_TRUE(bench.device.set_dip(8));
    EXPECT_TRUE(bench.send(8, rmd::ReadStatus1{}));
    EXPECT_FALSE(bench.send(2, rmd::ReadStatus1{}));
    EXPECT_FALSE(bench.device.set_dip(0));
    EXPECT_FALSE(bench.device.set_dip(9));
    EXPECT_EQ(bench.device.id(), 8);
}

TEST(RmdDevice, SendsTheLowByteFirst)
{
    covers("C 3");
    RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.start_rad = units::rad(258.0)}));
    const auto data = bench.send(rmd::ReadMultiTurnAngle{})->frame.data;
    EXPECT_EQ(data[1], 0xC8); // 25800 = 0x64C8
    EXPECT_EQ(data[2], 0x64);
    EXPECT_EQ(data[3], 0);
}

TEST(RmdDevice, AnswersTheMultiMotorFrameEarlierTheLowerItsId)
{
    covers("C 16");
    Duration before{};
    for (const int id : {1, 2, 3, 4}) {
        const auto answer = RmdBench(spec_of("rmd-2.35", "MF", id)).send(rmd::MultiMotorTorque{});
        ASSERT_TRUE(answer);
        EXPECT_GT(answer->delay, before);
        before = answer->delay;
    }
}

TEST(RmdDevice, EchoesAnUnknownCommandWhenBuiltSo)
{
    covers("C 19");
    RmdBench bench(spec_of("lk-2.36", "MF", 2, {.echoes_unknown = true}));
    const auto answer = bench.device.hear({.can_id = 0x142, .size = 8, .data = {0x77}}, bench.now);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->frame.can_id, 0x182U);
    EXPECT_EQ(answer->frame.data[0], 0x77);
    EXPECT_FALSE(bench.device.hear({.can_id = 0x143, .size = 8, .data = {0x77}}, bench.now));
}

TEST(RmdAngles, KeepTheirTurnsAtPowerOffWhenBuiltSo)
{
    covers("C 19");
    RmdBench bench(spec_of("rmd-2.35", "MF", 2, {.turns_kept = true}));
    bench.ask(rmd::MultiLoopAngle{.angle = -100'000});
    bench.run(10s);
    bench.device.power_cycle();
    EXPECT_NEAR(static_cast<double>(bench.ask(rmd::ReadMultiTurnAngle{}).angle), -100'000, 1);
}

} // namespace
} // namespace sinew::sim
