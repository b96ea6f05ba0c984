#include "sinew/sim/firmware/sam_device.hpp"

#include "sinew/base/units.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::covers;
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
    covers("A.2 1");
    covers("A.2 2");
    covers("A.2 3");
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
    covers("A.1 4");
    covers("A.13 6");
    SamBench bench(spec_of("SAM-20"));
    const auto ping = bench.send(5, sam::Ping{});
    ASSERT_TRUE(ping);
    EXPECT_EQ(ping->frame.data[0], 5);
    EXPECT_EQ(ping->frame.data[1], 5);
    EXPECT_FALSE(bench.send(4, sam::Ping{}));
    EXPECT_FALSE(bench.send(4, sam::SetPdGain{.p_gain = 1, .d_gain = 2}));
    EXPECT_EQ(bench.ask(sam::ReadPdGain{}).p_gain, SamGains{}.p);
}

TEST(SamDevice, IgnoresAWrongChecksumAndAValueThatDiffersFromItsRepeat)
{
    covers("A.1 1");
    covers("A.1 9");
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

TEST(SamDevice, TakesTheFirstOfTwoDifferingValuesWhenBuiltSo)
{
    covers("A.1 9");
    auto spec = spec_of("SAM-20");
    spec.device.repeats_checked = false;
    SamBench bench(spec);
    auto frame = *wire::encode_request(5, sam::SetIGain{.i_gain = 9});
    frame.data[5] = 8;
    frame.data[6] ^= 9 ^ 8;
    EXPECT_TRUE(bench.device.hear(frame, bench.now));
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 9);
}

// ---- response level ----

TEST(SamDevice, AnswersSetDriveModeByTheNewLevel)
{
    covers("A.2 5");
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
    covers("A.2 3");
    auto spec = spec_of("SAM-20", 0);
    spec.profile.ping_is_read = false;
    SamBench bench(spec);
    EXPECT_FALSE(bench.send(sam::Ping{}));
}

TEST(SamDevice, BrakesOnTheBroadcastAndSaysNothingUnlessBuiltToAnswer)
{
    covers("A.6 2");
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
    covers("A.9 1");
    covers("A.9 2");
    covers("A.9 3");
    covers("A.4 1");
    covers("A.8 3");
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
    covers("A.10 1");
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

TEST(SamDevice, ComesWithTenThousandWritesOfItsFlash)
{
    covers("A.10 1");
    SamBench bench(spec_of("SAM-20"));
    for (int write = 1; write <= 10'001; ++write)
        bench.send(sam::SetIGain{.i_gain = static_cast<std::uint8_t>(write <= 10'000 ? 7 : 9)});
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 9) << "it counts until the power is cut";
    EXPECT_EQ(bench.device.look().faults, "flash worn out");
    bench.device.power_cycle();
    EXPECT_EQ(bench.ask(sam::ReadIGain{}).i_gain, 7);
}

TEST(SamDevice, KeepsItsOwnIdThroughAFaultThatDoublesAnother)
{
    SamBench bench(spec_of("SAM-20"));
    bench.device.force_id(6);
    EXPECT_EQ(bench.ask(sam::Ping{}).id, 6);
    bench.ask(sam::SetIGain{.i_gain = 3});
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.id(), 6) << "as long as the fault lasts";
    bench.device.force_id(-1);
    EXPECT_EQ(bench.ask(sam::Ping{}).id, 5);
    bench.device.power_cycle();
    EXPECT_EQ(bench.device.id(), 5);
}

TEST(SamDevice, TakesAnotherIdAtOnce)
{
    covers("A.11 1");
    covers("A.11 2");
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
    covers("A.11 2");
    SamBench bench(spec_of("SAM-20"));
    const auto answer = bench.send(sam::SetBaudRate{.baud_code = 5});
    ASSERT_TRUE(answer);
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    bench.device.answered(bench.now);
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
    covers("A.13 5");
    for (const sam::Model& model : sam::models()) {
        SamBench bench(spec_of(model.name));
        EXPECT_EQ(bench.ask(sam::ReadFirmwareVersion{}).model_number, model.number);
    }
}

TEST(SamDevice, AcceptsBoundariesInBothOrdersAndNoEmptyRange)
{
    covers("A.4 1");
    SamBench bench(spec_of("SAM-20"));
    EXPECT_EQ(bench.ask(sam::QuickSetBoundary{.upper_boundary = 44, .lower_boundary = 210}).upper_boundary, 44);
    EXPECT_EQ(bench.ask(sam::QuickReadBoundary{}).upper_boundary, 210);
    EXPECT_FALSE(bench.send(sam::SetBoundary{.lower_boundary = 90, .upper_boundary = 90}));
    EXPECT_EQ(bench.ask(sam::ReadBoundary{}).upper_boundary, 254);
}

TEST(SamDevice, SharesItsBoundariesBetweenTheCoordinatesWhenBuiltSo)
{
    covers("A.4 3");
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
    covers("A.13 4");
    auto spec = spec_of("SAM-160");
    spec.device.supply_v = 20.0;
    SamBench cool(spec);
    EXPECT_EQ(cool.ask(sam::ReadInputVoltage{}).input_voltage, std::lround((20.0 - 0.65) / 0.00886));
    EXPECT_EQ(cool.ask(sam::ReadTemperatureError{}).temp_error, 0);
}

TEST(SamDevice, WorksAtTheRateOfEveryBaudCode)
{
    covers("A.1 7");
    constexpr std::uint32_t rates[] = {2'000'000, 1'500'000, 1'000'000, 500'000, 230'400,
                                       115'200,   57'600,    38'400,    9600,    4800};
    SamBench bench(spec_of("SAM-20"));
    EXPECT_EQ(bench.device.bit_rate(), 1'500'000U);
    std::uint8_t code = 0;
    for (const auto rate : rates) {
        EXPECT_EQ(bench.ask(sam::SetBaudRate{.baud_code = code}).new_baud_code, code);
        bench.device.answered(bench.now);
        EXPECT_EQ(bench.device.bit_rate(), rate);
        ++code;
    }
}

TEST(SamDevice, ComesOutOfTheFactoryWithIdZeroAndOnePointFiveMegabits)
{
    covers("A.11 1");
    const SamSettings factory;
    EXPECT_EQ(factory.id, 0);
    EXPECT_EQ(factory.bit_rate, 1'500'000U);
    EXPECT_EQ(factory.response_level, 0);
}

TEST(SamDevice, TakesElevenForARunTimeIGainUnlessItIsStrict)
{
    covers("A.9 4");
    auto spec = spec_of("SAM-20");
    EXPECT_TRUE(SamBench(spec).send(sam::SetRuntimeIGain{.i_gain = 11}));
    spec.profile.i_gain_strict = true;
    SamBench strict(spec);
    EXPECT_TRUE(strict.send(sam::SetRuntimeIGain{.i_gain = 10}));
    EXPECT_FALSE(strict.send(sam::SetRuntimeIGain{.i_gain = 11}));
    EXPECT_EQ(strict.ask(sam::ReadIGain{}).i_gain, 10);
}

TEST(SamDevice, OfTheEncoderClassGoesBackToIdZeroByTheSwitchInside)
{
    covers("A.11 3");
    for (const bool encoder : {true, false}) {
        SamBench bench(spec_of(encoder ? "SAM-160" : "SAM-20"));
        bench.send(sam::SetBaudRate{.baud_code = 5});
        bench.device.answered(bench.now);
        bench.device.press_reset(4900ms);
        EXPECT_EQ(bench.device.id(), 5);
        bench.device.press_reset(5s);
        bench.device.power_cycle();
        EXPECT_EQ(bench.device.id(), encoder ? 0 : 5);
        EXPECT_EQ(bench.device.bit_rate(), encoder ? 1'500'000U : 115'200U);
    }
}

TEST(SamDevice, PutsOutAtPowerOnWhatItIsBuiltFor)
{
    covers("A.12 5");
    auto spec = spec_of("SAM-160");
    spec.device.port_at_power_on = 0b1010;
    SamBench bench(spec);
    bench.ask(sam::WriteExternalPort{.led_red = true});
    bench.device.power_cycle();
    const auto port = bench.device.port();
    EXPECT_FALSE(port.led_red);
    EXPECT_TRUE(port.led_blue);
    EXPECT_FALSE(port.do1);
    EXPECT_TRUE(port.do2);
}

TEST(SamDevice, PutsOutWhatTheExternalPortIsToldUntilPowerOff)
{
    covers("A.12 2");
    covers("A.12 3");
    covers("A.12 5");
    SamBench bench(spec_of("SAM-160"));
    EXPECT_FALSE(bench.device.port().do1);
    bench.ask(sam::WriteExternalPort{.led_red = true, .do2 = true});
    EXPECT_TRUE(bench.device.port().led_red);
    EXPECT_FALSE(bench.device.port().led_blue);
    EXPECT_FALSE(bench.device.port().do1);
    EXPECT_TRUE(bench.device.port().do2);
    bench.device.power_cycle();
    EXPECT_FALSE(bench.device.port().led_red);
    EXPECT_FALSE(bench.device.port().do2);
}

TEST(SamDevice, ReadsTheVoltageAtItsExternalPort)
{
    covers("A.12 1");
    auto spec = spec_of("SAM-160");
    spec.device.external_v = 3.3;
    SamBench bench(spec);
    EXPECT_EQ(bench.ask(sam::ReadExternalAd{}).external_ad, 2457); // 3.3 V / 0.001343 V
    bench.device.set_external(9.0);
    EXPECT_EQ(bench.ask(sam::QuickReadExternalAd{}).external_ad, 4095);
    bench.device.set_external(0.0);
    EXPECT_EQ(bench.ask(sam::ReadExternalAd{}).external_ad, 0);
}

// ---- bytes ----

TEST(SamDevice, TakesRequestsOfTheSizesOfTheManualAndAnswersWithBareBytes)
{
    covers("A.1 2");
    covers("A.1 3");
    covers("A.1 6");
    const wire::Options options = spec_of("SAM-160").profile.options();
    for (const auto* message : sam::manual_messages) {
        SamBench bench(spec_of("SAM-160"));
        const auto frame =
            wire::encode(*message, wire::Direction::request, 5, sample_values(*message, options), options);
        ASSERT_TRUE(frame) << message->name();
        const std::string_view name = message->name();
        const bool precise = name.find("precise") != std::string_view::npos;
        const int size = frame->data[1] < 0xE0 ? 4 : frame->data[2] < 0xA0 ? 6 : precise ? 8 : 7;
        if (!name.ends_with("write-motion-data")) {
            EXPECT_EQ(frame->size, size) << name;
        }
        EXPECT_EQ(frame->data[0], 0xFF) << name;
        for (std::size_t i = 1; i < frame->size; ++i)
            EXPECT_NE(frame->data[i], 0xFF) << name;
        const auto answer = bench.device.hear(*frame, bench.now);
        if (name == "set-drive-mode") // the sample is level 0, which has no answer
            continue;
        ASSERT_TRUE(answer) << name;
        EXPECT_EQ(answer->frame.size, precise ? 3 : 2) << name;
    }
}

TEST(SamDevice, OfIdZeroTellsQuickSetFromStandardCommandsByTheirOpcode)
{
    covers("A.1 5");
    auto spec = spec_of("SAM-20");
    spec.id = 0;
    SamBench bench(spec);
    EXPECT_TRUE(bench.send(0, sam::QuickSetRuntimePdGain{.p_gain = 31, .d_gain = 32}));
    EXPECT_EQ(bench.ask(sam::ReadPdGain{}).p_gain, 31);
    EXPECT_TRUE(bench.send(0, sam::SetRuntimePdGain{.p_gain = 41, .d_gain = 42}));
    EXPECT_EQ(bench.ask(sam::ReadPdGain{}).p_gain, 41);
}

} // namespace
} // namespace sinew::sim
