#include "sinew/sim/firmware/nuri_for_tests.hpp"

#include "sinew/base/units.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

namespace sinew::sim {
namespace {

using test::covers;
using namespace std::chrono_literals;
using enum nuri::Rotation;

/// Lets the device of the bench hear the sample of the message.
std::optional<Answer> hear_sample(NuriBench& bench, const wire::MessageInfo& message, int id)
{
    const auto frame = wire::encode(message, wire::Direction::request, id, sample_values(message, {}));
    EXPECT_TRUE(frame) << message.name();
    return frame ? bench.device.hear(*frame, bench.now) : std::nullopt;
}

TEST(NuriDevice, AnswersFeedbackRequestsOfBothLinesAndNothingElse)
{
    covers("B 3");
    for (const std::size_t line : {rsa, mc}) {
        const nuri::Spec spec = spec_of(line);
        int requests = 0;
        for (const auto* message : spec.profile.line.messages) {
            if (!message->request.exists())
                continue;
            ++requests;
            NuriBench bench(spec);
            const auto answer = hear_sample(bench, *message, 3);
            EXPECT_EQ(answer.has_value(), message->reply.exists()) << message->name();
            if (answer) {
                EXPECT_TRUE(wire::decode(*message, wire::Direction::reply, answer->frame)) << message->name();
            }
        }
        EXPECT_EQ(requests, line == rsa ? 24 : 29);
    }
}

TEST(NuriDevice, ObeysTheBroadcastWithoutAWord)
{
    covers("B 2");
    NuriBench bench(spec_of());
    EXPECT_FALSE(bench.send(255, nuri::SetResponseTime{.response_time = 9}));
    EXPECT_EQ(bench.ask(nuri::RequestResponseTimeFeedback{}).response_time, 9);
}

TEST(NuriDevice, ObeysNobodyElsesId)
{
    NuriBench bench(spec_of());
    EXPECT_FALSE(bench.send(4, nuri::SetResponseTime{.response_time = 9}));
    EXPECT_FALSE(bench.send(4, nuri::RequestPing{}));
    EXPECT_EQ(bench.ask(nuri::RequestResponseTimeFeedback{}).response_time, 1);
}

TEST(NuriDevice, WaitsItsResponseTimeInSteps)
{
    covers("B 4");
    NuriBench bench(spec_of());
    EXPECT_EQ(bench.send(nuri::RequestPing{})->delay, 100us);
    bench.send(nuri::SetResponseTime{.response_time = 254});
    EXPECT_EQ(bench.send(nuri::RequestPing{})->delay, 25'400us);
    bench.send(nuri::SetResponseTime{.response_time = 0});
    EXPECT_EQ(bench.send(nuri::RequestPing{})->delay, 0us);
}

TEST(NuriDevice, StartsWithTheSettingsOfItsProfile)
{
    auto spec = spec_of();
    spec.profile.response_time_us = 700.0;
    spec.profile.external_gear_ratio = 2.5;
    NuriBench bench(spec);
    EXPECT_EQ(bench.ask(nuri::RequestResponseTimeFeedback{}).response_time, 7);
    EXPECT_EQ(bench.ask(nuri::RequestGearRatioFeedback{}).gear_ratio, 25);
}

TEST(NuriDevice, KeepsItsSettingsAtPowerOffUnlessBuiltNotTo)
{
    covers("B 7");
    covers("B 15");
    for (const bool persist : {true, false}) {
        auto spec = spec_of();
        spec.device.settings_persist = persist;
        NuriBench bench(spec);
        bench.send(nuri::SetPositionController{
            .position_kp = 1, .position_ki = 2, .position_kd = 3, .position_rated_current = 4});
        bench.send(nuri::SetSpeedController{.speed_kp = 5, .speed_ki = 6, .speed_kd = 7, .speed_rated_current = 8});
        bench.send(nuri::SetPositionControlMode{.position_mode = nuri::PositionMode::relative});
        bench.send(nuri::SetControlOnOff{.control = nuri::Control::off});
        bench.device.power_cycle();
        const auto position = bench.ask(nuri::RequestPositionControllerFeedback{});
        const auto speed = bench.ask(nuri::RequestSpeedControllerFeedback{});
        EXPECT_EQ(position.position_kp == 1 && position.position_ki == 2 && position.position_kd == 3 &&
                      position.position_rated_current == 4,
                  persist);
        EXPECT_EQ(speed.speed_kp == 5 && speed.speed_rated_current == 8, persist);
        EXPECT_EQ(bench.ask(nuri::RequestPositionModeFeedback{}).position_mode == nuri::PositionMode::relative,
                  persist);
        EXPECT_EQ(bench.ask(nuri::RequestControlOnOffFeedback{}).control == nuri::Control::off, persist);
    }
}

TEST(NuriDevice, IgnoresMoreThanItsRatedCurrent)
{
    covers("B 7");
    NuriBench bench(spec_of());
    const auto before = bench.ask(nuri::RequestPositionControllerFeedback{});
    EXPECT_EQ(before.position_rated_current, 10);
    bench.send(nuri::SetPositionController{.position_kp = 9, .position_rated_current = 11});
    EXPECT_EQ(bench.ask(nuri::RequestPositionControllerFeedback{}).position_kp, before.position_kp);
}

TEST(NuriDevice, TakesAnotherIdAndBitRateAtOnce)
{
    covers("B 5");
    covers("B 16");
    NuriBench bench(spec_of());
    bench.send(nuri::SetId{.new_id = 77});
    EXPECT_EQ(bench.device.id(), 77);
    EXPECT_FALSE(bench.send(3, nuri::RequestPing{}));
    bench.send(nuri::SetBaudRate{.baud_code = 0x0D});
    EXPECT_EQ(bench.device.bit_rate(), 115'200U);
}

TEST(NuriDevice, TakesAnotherIdAndBitRateAtPowerOnWhenBuiltSo)
{
    covers("B 16");
    auto spec = spec_of();
    spec.device.bus_switch = nuri::BusSwitch::at_power_on;
    NuriBench bench(spec);
    bench.send(nuri::SetBaudRate{.baud_code = 0x0D});
    bench.send(nuri::SetId{.new_id = 77});
    bench.run(1s);
    EXPECT_EQ(bench.device.id(), 3);
    EXPECT_EQ(bench.device.bit_rate(), 9600U);
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.id(), 77);
    EXPECT_EQ(bench.device.bit_rate(), 115'200U);
}

TEST(NuriDevice, FactoryResetRestoresEverything)
{
    covers("B 12");
    NuriBench bench(spec_of());
    bench.send(nuri::SetBaudRate{.baud_code = 0x0D});
    bench.send(nuri::SetExternalGearRatio{.gear_ratio = 50});
    bench.send(nuri::SetControlOnOff{.control = nuri::Control::off});
    bench.send(nuri::FactoryReset{});
    EXPECT_EQ(bench.device.id(), 0);
    EXPECT_EQ(bench.device.bit_rate(), 9600U);
    EXPECT_EQ(bench.ask(nuri::RequestGearRatioFeedback{}).gear_ratio, 10);
    EXPECT_EQ(bench.ask(nuri::RequestControlOnOffFeedback{}).control, nuri::Control::on);
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.id(), 0);
}

TEST(NuriDevice, OfTheMcLineTakes0x0CAnd0x0DForItsOwnCommands)
{
    NuriBench bench(spec_of(mc));
    bench.send(nuri::mc::SetControlOnOff{.control = nuri::Control::off});
    bench.send(nuri::mc::SetPositionControlMode{.position_mode = nuri::PositionMode::relative});
    EXPECT_EQ(bench.device.id(), 3);
    EXPECT_EQ(bench.ask(nuri::mc::RequestControlOnOffFeedback{}).control, nuri::Control::off);
    EXPECT_EQ(bench.ask(nuri::mc::RequestPositionModeFeedback{}).position_mode, nuri::PositionMode::relative);
    bench.send(nuri::mc::SetRatedSpeed{.rated_speed = 3000});
    bench.send(nuri::mc::SetResolution{.resolution = 1024});
    bench.send(nuri::mc::SetControlDirection{.control_direction = clockwise});
    EXPECT_EQ(bench.ask(nuri::mc::RequestRatedSpeedFeedback{}).rated_speed, 3000);
    EXPECT_EQ(bench.ask(nuri::mc::RequestResolutionFeedback{}).resolution, 1024);
    EXPECT_EQ(bench.ask(nuri::mc::RequestControlDirectionFeedback{}).control_direction, clockwise);
}

TEST(NuriDevice, SwitchesOffToAFreeShaftAndForgetsItsTarget)
{
    covers("B 9");
    NuriBench bench(spec_of());
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 9000, 50});
    bench.run(500ms);
    bench.send(nuri::SetControlOnOff{.control = nuri::Control::off});
    bench.run(5s);
    const double rest = bench.device.look().position_rad;
    EXPECT_LT(rest, units::rad(80.0));
    EXPECT_EQ(bench.device.look().mode, "off");
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 9000, 50});
    bench.send(nuri::SetControlOnOff{.control = nuri::Control::on});
    bench.run(5s);
    EXPECT_EQ(bench.device.look().position_rad, rest);
}

TEST(NuriDevice, CarriesOutWhatCameWhileOffWhenBuiltSo)
{
    covers("B 9");
    auto spec = spec_of();
    spec.device.off_keeps_target = true;
    NuriBench bench(spec);
    bench.send(nuri::SetControlOnOff{.control = nuri::Control::off});
    bench.send(nuri::PositionSpeedControl{counter_clockwise, 9000, 50});
    bench.run(1s);
    EXPECT_EQ(bench.device.look().position_rad, 0.0);
    bench.send(nuri::SetControlOnOff{.control = nuri::Control::on});
    bench.run(10s);
    EXPECT_NEAR(bench.device.look().position_rad, units::rad(90.0), rest_rad);
}

TEST(NuriDevice, FramesItsAnswerWithTheNegatedSum)
{
    covers("B 1");
    NuriBench bench(spec_of());
    const wire::Frame frame = bench.send(nuri::RequestResponseTimeFeedback{})->frame;
    // FF FE, ID 3, size 3, checksum, mode 0xD5, value 1: ~(03 + 03 + D5 + 01)
    EXPECT_EQ(frame.size, 7);
    EXPECT_EQ(frame.data[0], 0xFF);
    EXPECT_EQ(frame.data[1], 0xFE);
    EXPECT_EQ(frame.data[2], 3);
    EXPECT_EQ(frame.data[3], 3);
    EXPECT_EQ(frame.data[4], static_cast<std::uint8_t>(~(3 + 3 + frame.data[5] + 1)));
    EXPECT_EQ(frame.data[6], 1);
}

TEST(NuriDevice, KeepsItsIdAndBitRateAtAFactoryResetWhenBuiltSo)
{
    covers("B 12");
    auto spec = spec_of();
    spec.device.reset_keeps_bus = true;
    NuriBench bench(spec);
    bench.send(nuri::SetBaudRate{.baud_code = 0x0D});
    bench.send(nuri::SetExternalGearRatio{.gear_ratio = 50});
    bench.send(nuri::FactoryReset{});
    EXPECT_EQ(bench.device.id(), 3);
    EXPECT_EQ(bench.device.bit_rate(), 115'200U);
    EXPECT_EQ(bench.ask(nuri::RequestGearRatioFeedback{}).gear_ratio, 10);
}

} // namespace
} // namespace sinew::sim
