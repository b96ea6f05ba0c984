#include "sinew/sim/firmware/sam_device.hpp"

#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using SamBench = Bench<SamDevice>;

sam::Spec spec_of(std::string_view model, int response_level = 1)
{
    sam::Spec spec{.model = sam::find_model(model), .profile = sam::profiles()[0], .id = 5};
    spec.device.response_level = response_level;
    return spec;
}

/// Whether a device at this level says anything to the sample of the message.
bool answered(std::string_view model, const wire::MessageInfo& message, int level)
{
    SamBench bench(spec_of(model, level));
    const wire::Options options = spec_of(model).profile.options();
    wire::Values values;
    for (const wire::Value& value : sample_values(message, options))
        values.add(*value.field, value.field->name == "response_level" ? level : value.raw);
    const auto frame = wire::encode(message, wire::Direction::request, 5, values, options);
    EXPECT_TRUE(frame) << message.name() << ": " << (frame ? "" : to_sentence(frame.error()));
    if (!frame)
        return false;
    const auto answer = bench.device.hear(*frame, bench.now);
    if (answer) {
        EXPECT_TRUE(wire::decode(message, wire::Direction::reply, answer->frame, options)) << message.name();
    }
    return answer.has_value();
}

TEST(SamDevice, AnswersEveryMessageAtLevelOneReadsOnlyAtLevelZeroAndNothingAtLevelTwo)
{
    ASSERT_EQ(sam::manual_messages.size(), 57U);
    for (const auto* message : sam::manual_messages) {
        EXPECT_TRUE(answered("SAM-160", *message, 1)) << message->name();
        EXPECT_EQ(answered("SAM-160", *message, 0), !message->info.answered_as_command) << message->name();
        EXPECT_FALSE(answered("SAM-160", *message, 2)) << message->name();
    }
}

TEST(SamDevice, OfAPotentiometerModelIsSilentAboutMessagesOfTheEncoderClass)
{
    for (const auto* message : sam::manual_messages)
        EXPECT_EQ(answered("SAM-20", *message, 1), message->info.restriction.empty()) << message->name();
}

TEST(SamDevice, HearsOnlyItsOwnId)
{
    SamBench bench(spec_of("SAM-20"));
    EXPECT_TRUE(bench.send(5, sam::Ping{}));
    EXPECT_FALSE(bench.send(4, sam::Ping{}));
    EXPECT_FALSE(bench.send(4, sam::SetPdGain{.p_gain = 1, .d_gain = 2}));
    EXPECT_EQ(bench.ask(sam::ReadPdGain{}).p_gain, SamGains{}.p);
}

TEST(SamDevice, IgnoresAWrongChecksumAndAValueThatDiffersFromItsRepeat)
{
    SamBench bench(spec_of("SAM-20"));
    auto frame = *wire::encode_request(5, sam::SetIGain{.i_gain = 9});
    frame.data[6] ^= 1;
    EXPECT_FALSE(bench.device.hear(frame, bench.now));
    frame.data[6] ^= 1;
    frame.data[5] = 8;
    frame.data[6] ^= 9 ^ 8;
    EXPECT_FALSE(bench.device.hear(frame, bench.now));
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 0);
}

// ---- response level ----

TEST(SamDevice, AnswersSetDriveModeByTheNewLevel)
{
    SamBench bench(spec_of("SAM-20", 0));
    EXPECT_TRUE(bench.send(sam::SetDriveMode{.response_level = 1}));
    EXPECT_FALSE(bench.send(sam::SetDriveMode{.response_level = 2}));
    EXPECT_FALSE(bench.send(sam::ReadDriveMode{}));
    EXPECT_TRUE(bench.send(sam::SetDriveMode{.response_level = 1}));
}

TEST(SamDevice, AnswersSetDriveModeByTheOldLevelWhenBuiltSo)
{
    auto spec = spec_of("SAM-20", 0);
    spec.device.drive_mode_reply = sam::DriveModeReply::old_level;
    SamBench bench(spec);
    EXPECT_FALSE(bench.send(sam::SetDriveMode{.response_level = 1}));
    EXPECT_TRUE(bench.send(sam::SetDriveMode{.response_level = 2}));
}

TEST(SamDevice, TakesPingForACommandWhenTheProfileSaysSo)
{
    auto spec = spec_of("SAM-20", 0);
    spec.profile.ping_is_read = false;
    SamBench bench(spec);
    EXPECT_FALSE(bench.send(sam::Ping{}));
}

TEST(SamDevice, BrakesOnTheBroadcastAndSaysNothingUnlessBuiltToAnswer)
{
    auto spec = spec_of("SAM-20");
    SamBench silent(spec);
    EXPECT_FALSE(silent.send(31, sam::QuickBrakeMode{}));
    EXPECT_EQ(silent.device.look().mode, "brake");
    spec.device.brake_broadcast_reply = true;
    SamBench talking(spec);
    EXPECT_TRUE(talking.send(31, sam::QuickBrakeMode{}));
}

// ---- settings ----

TEST(SamDevice, KeepsFlashSettingsAndForgetsRunTimeOnesAtPowerOff)
{
    SamBench bench(spec_of("SAM-160"));
    bench.ask(sam::SetPdGain{.p_gain = 11, .d_gain = 12});
    bench.ask(sam::SetIGain{.i_gain = 13});
    bench.ask(sam::SetRuntimePdGain{.p_gain = 21, .d_gain = 22});
    bench.ask(sam::SetRuntimeIGain{.i_gain = 3});
    bench.ask(sam::SetOverload{.overload = 1234});
    bench.ask(sam::SetBoundary{.lower_boundary = 30, .upper_boundary = 200});
    bench.ask(sam::QuickSetBoundary{.upper_boundary = 210, .lower_boundary = 44});
    bench.ask(sam::SetAvgTorque{.avg_torque = 700});
    bench.ask(sam::WriteMotionData{.motion_count = 2, .instructions = {{{0x10, 82}, {0x31, 10}}}});
    bench.ask(sam::SetCtrlSpeed{.ctrl_speed = 77});
    EXPECT_EQ(bench.ask(sam::ReadPdGain{}).p_gain, 21);

    bench.device.power_cycle();
    const auto gains = bench.ask(sam::ReadPdGain{});
    EXPECT_EQ(gains.p_gain, 11);
    EXPECT_EQ(gains.d_gain, 12);
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 13);
    EXPECT_EQ(bench.ask(sam::ReadOverload{}).overload, 1234);
    EXPECT_EQ(bench.ask(sam::QuickReadOverload{}).overload, 1234 >> 4);
    EXPECT_EQ(bench.ask(sam::ReadBoundary{}).lower_boundary, 30);
    EXPECT_EQ(bench.ask(sam::ReadBoundary{}).upper_boundary, 200);
    EXPECT_EQ(bench.ask(sam::QuickReadBoundary{}).lower_boundary, 44);
    EXPECT_EQ(bench.ask(sam::QuickReadBoundary{}).upper_boundary, 210);
    EXPECT_EQ(bench.ask(sam::ReadAvgTorque{}).avg_torque, 700);
    EXPECT_EQ(bench.ask(sam::ReadMotionData{}).motion_count, 2);
    EXPECT_EQ(bench.ask(sam::ReadCtrlSpeed{}).ctrl_speed, 0);
}

TEST(SamDevice, CountsItsFlashWritesAndStoresNothingWhenItsFlashIsWornOut)
{
    auto spec = spec_of("SAM-20");
    spec.device.flash_writes_max = 2;
    SamBench bench(spec);
    for (std::uint8_t gain = 1; gain <= 3; ++gain)
        bench.ask(sam::SetIGain{.i_gain = gain});
    bench.ask(sam::SetRuntimeIGain{.i_gain = 4});
    EXPECT_EQ(bench.device.flash_writes(), 3U);
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 2);
}

TEST(SamDevice, TakesAnotherIdAtOnce)
{
    SamBench bench(spec_of("SAM-20"));
    EXPECT_EQ(bench.ask(sam::SetId{.new_id = 200}).new_id, 200);
    EXPECT_EQ(bench.device.id(), 200);
    EXPECT_FALSE(bench.send(5, sam::Ping{}));
    EXPECT_EQ(bench.ask(sam::Ping{}).id, 200);
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.id(), 200);
}

TEST(SamDevice, SwitchesItsBitRateAfterTheReplyIsOut)
{
    SamBench bench(spec_of("SAM-20"));
    const auto answer = bench.send(sam::SetBaudRate{.baud_code = 5});
    ASSERT_TRUE(answer);
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    const Duration reply_out = answer->delay + bit_time(20, 1'500'000);
    bench.run(reply_out - 1ns);
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    bench.run(1ns);
    EXPECT_EQ(bench.device.bit_rate(), 115'200U);
}

TEST(SamDevice, SwitchesItsBitRateAtPowerOnWhenBuiltSo)
{
    auto spec = spec_of("SAM-20");
    spec.device.baud_switch = sam::BaudSwitch::at_power_on;
    SamBench bench(spec);
    bench.send(sam::SetBaudRate{.baud_code = 5});
    bench.run(1s);
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.bit_rate(), 115'200U);
}

TEST(SamDevice, TellsItsModelNumber)
{
    for (const sam::Model& model : sam::models()) {
        SamBench bench(spec_of(model.name));
        EXPECT_EQ(bench.ask(sam::ReadFirmwareVersion{}).model_number, model.number);
    }
}

TEST(SamDevice, AcceptsBoundariesInBothOrdersAndNoEmptyRange)
{
    SamBench bench(spec_of("SAM-20"));
    EXPECT_EQ(bench.ask(sam::QuickSetBoundary{.upper_boundary = 44, .lower_boundary = 210}).upper_boundary, 44);
    EXPECT_EQ(bench.ask(sam::QuickReadBoundary{}).upper_boundary, 210);
    EXPECT_FALSE(bench.send(sam::SetBoundary{.lower_boundary = 90, .upper_boundary = 90}));
    EXPECT_EQ(bench.ask(sam::ReadBoundary{}).upper_boundary, 254);
}

TEST(SamDevice, SharesItsBoundariesBetweenTheCoordinatesWhenBuiltSo)
{
    auto spec = spec_of("SAM-160");
    spec.device.boundary_storage = sam::BoundaryStorage::shared_raw;
    SamBench raw(spec);
    raw.ask(sam::SetBoundary{.lower_boundary = 63, .upper_boundary = 191});
    EXPECT_EQ(raw.ask(sam::QuickReadBoundary{}).upper_boundary, 191);
    spec.device.boundary_storage = sam::BoundaryStorage::shared_angle;
    SamBench angle(spec);
    angle.ask(sam::SetBoundary{.lower_boundary = 63, .upper_boundary = 191});
    EXPECT_EQ(angle.ask(sam::QuickReadBoundary{}).upper_boundary, 211); // 64 · 1.41 / 1.08 = 83.6
}

TEST(SamDevice, ReadsItsSupplyAndTemperature)
{
    auto spec = spec_of("SAM-160");
    spec.device.supply_v = 20.0;
    SamBench cool(spec);
    EXPECT_EQ(cool.ask(sam::ReadInputVoltage{}).input_voltage, std::lround((20.0 - 0.65) / 0.00886));
    EXPECT_EQ(cool.ask(sam::ReadTemperatureError{}).temp_error, 0);
    spec.device.temperature_c = 65.0;
    SamBench hot(spec);
    EXPECT_EQ(hot.ask(sam::ReadTemperatureError{}).temp_error, 1);
    hot.ask(sam::PositionControl{.target_position = 20000});
    hot.run(1s);
    EXPECT_EQ(hot.ask(sam::ReadCurrentPosition{}).position, 14504);
}

} // namespace
} // namespace sinew::sim
