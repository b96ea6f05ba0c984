#include "sinew/family/rmd/models.hpp"

#include "sinew/family/rmd/lines.hpp"
#include "sinew/wire/codec.hpp"

#include <gtest/gtest.h>

namespace sinew::rmd {
namespace {

const Profile& line(std::string_view name)
{
    for (const Profile& profile : profiles())
        if (profile.line.name == name)
            return profile;
    ADD_FAILURE() << name;
    return profiles().front();
}

Spec spec_of(std::string_view model, std::string_view profile)
{
    return make_spec(*find_model(model), line(profile), 1);
}

wire::Reading reading_of(const Spec& spec, std::string_view message, std::string_view field)
{
    const wire::MessageInfo* info = spec.profile.line.find(message);
    for (const auto* side : {&info->reply, &info->request})
        if (side->exists())
            for (const wire::Field& f : side->fields)
                if (f.name == field)
                    return wire::reading(*info, f, spec.profile.line.overrides,
                                         std::span(spec.overrides).first(spec.override_count));
    ADD_FAILURE() << message << " has no " << field;
    return {};
}

std::vector<std::uint8_t> bytes(const wire::Frame& frame)
{
    return {frame.data.begin(), frame.data.begin() + frame.size};
}

TEST(RmdLines, AreTheFiveWithTheManualFirst)
{
    std::vector<std::string_view> names;
    for (const Profile& profile : profiles())
        names.push_back(profile.line.name);
    EXPECT_EQ(names, (std::vector<std::string_view>{"rmd-2.35", "lk-2.35", "lk-2.36", "gyems-1.62", "myactuator-3"}));
    EXPECT_EQ(profiles().front().line.messages.size(), 28U);
}

TEST(RmdLines, RefuseWhatTheirDocumentsDoNotList)
{
    const auto lacks = [](std::string_view name, std::string_view message) {
        return line(name).line.find(message) == nullptr;
    };
    EXPECT_TRUE(lacks("lk-2.35", "write-parameter-rom"));
    EXPECT_TRUE(lacks("lk-2.35", "read-acceleration"));
    EXPECT_TRUE(lacks("lk-2.36", "write-encoder-offset"));
    EXPECT_TRUE(lacks("lk-2.36", "speed-closed-loop-torque"));
    EXPECT_TRUE(lacks("gyems-1.62", "set-current-position-zero"));
    EXPECT_TRUE(lacks("myactuator-3", "motor-running"));
    EXPECT_TRUE(lacks("myactuator-3", "single-loop-angle"));
    EXPECT_TRUE(lacks("rmd-2.35", "brake-control"));
    EXPECT_FALSE(line("lk-2.35").line.has(wire::info_of<ReadStatus1>)) << "the manual's layout is another one";
}

TEST(RmdLines, RepliesComeOnTheIdentifierOfTheLine)
{
    EXPECT_EQ(wire::encode_reply<MotorOff>(3, {}, line("rmd-2.35").options())->can_id, 0x143U);
    EXPECT_EQ(wire::encode_reply<MotorOff>(3, {}, line("lk-2.35").options())->can_id, 0x143U);
    EXPECT_EQ(wire::encode_reply<MotorOff>(3, {}, line("lk-2.36").options())->can_id, 0x183U);
    EXPECT_EQ(wire::encode_reply<MotorOff>(3, {}, line("myactuator-3").options())->can_id, 0x243U);
    for (const Profile& profile : profiles()) {
        EXPECT_EQ(profile.line.options.can_reply_base, profile.options().can_reply_base) << profile.line.name;
        EXPECT_EQ(profile.line.options.bits, profile.options().bits) << profile.line.name;
        EXPECT_EQ(wire::encode_request(3, MotorOff{}, profile.options())->can_id, 0x143U);
    }
}

TEST(RmdLines, MaxSpeedCountsHundredthsOnlyInTheManual)
{
    // R01: 90 dps is 9000 in the manual's example and 90 on every other line
    Profile manual = line("rmd-2.35");
    manual.max_speed_confirmed = true;
    EXPECT_DOUBLE_EQ(
        reading_of(make_spec(*find_model("MG"), manual, 1), "multi-loop-angle-speed", "max_speed").physical(9000), 90);
    for (const auto* name : {"lk-2.35", "lk-2.36", "gyems-1.62", "myactuator-3"}) {
        EXPECT_EQ(line(name).max_speed_lsb_dps, 1.0) << name;
        EXPECT_DOUBLE_EQ(reading_of(spec_of("MG", name), "multi-loop-angle-speed", "max_speed").physical(90), 90)
            << name;
    }
    for (const auto* message : {"single-loop-angle-speed", "increment-angle-speed"})
        EXPECT_DOUBLE_EQ(reading_of(spec_of("MG", "lk-2.35"), message, "max_speed").physical(90), 90) << message;
}

TEST(RmdLines, AnUnconfirmedMaxSpeedIsSentInTheScaleThatCanOnlyBeSlow)
{
    Profile manual = line("rmd-2.35");
    EXPECT_FALSE(manual.max_speed_confirmed);
    EXPECT_EQ(manual.sent_max_speed_lsb_dps(), 1.0);
    // By name as well: 90 dps must not become 9000 for a motor that may count whole degrees.
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MG", "rmd-2.35"), "multi-loop-angle-speed", "max_speed").physical(90), 90);
    manual.max_speed_confirmed = true;
    EXPECT_EQ(manual.sent_max_speed_lsb_dps(), 0.01);
    EXPECT_EQ(line("lk-2.35").sent_max_speed_lsb_dps(), 1.0);
}

TEST(RmdLines, AnOptionChangesTheScaleOfMaxSpeedForTheCodecByName)
{
    Profile manual = line("rmd-2.35");
    manual.max_speed_lsb_dps = 1.0;
    const Spec spec = make_spec(*find_model("MF"), manual, 1);
    EXPECT_EQ(reading_of(spec, "multi-loop-angle-speed", "max_speed").scale, 1.0);
    EXPECT_EQ(reading_of(spec, "read-parameter", "value").scale, 1.0);
}

TEST(RmdModels, TorqueCurrentIsThatOfTheClass)
{
    // L777, L798 and L98 (R11): ±2048 is 16.5 A on MF and RMD-L, 33 A on MG
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MF", "rmd-2.35"), "read-status2", "iq").physical(2048), 16.5);
    EXPECT_DOUBLE_EQ(reading_of(spec_of("RMD-L", "rmd-2.35"), "torque-closed-loop", "iq").physical(2048), 16.5);
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MG", "rmd-2.35"), "read-status2", "iq").physical(2048), 33.0);
    // LK V2.35: 33/4096 and 66/4096 A per unit
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MF", "lk-2.35"), "read-status2", "iq").scale, 33.0 / 4096);
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MG", "lk-2.35"), "read-status2", "iq").scale, 66.0 / 4096);
    EXPECT_DOUBLE_EQ(*spec_of("MG", "lk-2.35").iq_a(), 66.0 / 4096);
}

TEST(RmdModels, AnMgMayBePrintedAs32Amperes)
{
    Profile profile = line("rmd-2.35");
    profile.torque_current_full_scale_a = 32.0;
    EXPECT_DOUBLE_EQ(*make_spec(*find_model("MG"), profile, 1).iq_a(), 1.0 / 64.0);
}

TEST(RmdModels, AClassWithoutTorqueCurrentStaysInRawUnits)
{
    EXPECT_FALSE(spec_of("RMD", "rmd-2.35").iq_a());
    EXPECT_FALSE(spec_of("MS", "lk-2.35").iq_a());
    const wire::Reading power = reading_of(spec_of("MS", "lk-2.35"), "read-status2", "iq");
    EXPECT_EQ(power.range, (Range{-1000, 1000}));
    EXPECT_EQ(power.scale, wire::by_model);
}

TEST(RmdModels, MyActuatorCountsHundredthsOfAnAmpereOnEveryMotor)
{
    for (const Model& model : models()) {
        const Spec spec = make_spec(model, line("myactuator-3"), 1);
        EXPECT_EQ(*spec.iq_a(), 0.01) << model.name;
        EXPECT_EQ(reading_of(spec, "read-status2", "iq").scale, 0.01) << model.name;
        EXPECT_EQ(reading_of(spec, "read-status3", "phase_b_current").scale, 0.01) << model.name;
    }
}

TEST(RmdModels, PhaseCurrentsAreThoseOfTheLine)
{
    EXPECT_EQ(reading_of(spec_of("MG", "rmd-2.35"), "read-status3", "phase_a_current").scale, 1.0 / 64);
    EXPECT_EQ(reading_of(spec_of("MF", "gyems-1.62"), "read-status3", "phase_a_current").scale, 1.0 / 64);
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MF", "lk-2.35"), "read-status3", "phase_c_current").scale, 33.0 / 4096);
}

TEST(RmdModels, EncoderRangesFollowTheBitsUpToSixteen)
{
    for (const auto& [bits, high] : {std::pair{12, 4095}, std::pair{14, 16383}, std::pair{16, 65535}, {18, 65535}}) {
        Profile profile = line("rmd-2.35");
        profile.encoder_bits = bits;
        const Spec spec = make_spec(*find_model("MF"), profile, 1);
        EXPECT_EQ(reading_of(spec, "read-encoder", "encoder_raw").range, (Range{0, high})) << bits;
        EXPECT_EQ(reading_of(spec, "read-status2", "encoder").range, (Range{0, high})) << bits;
    }
}

TEST(RmdRows, LkStatus1HasVoltageCurrentStateAndFlagsInItsOwnPlaces)
{
    const auto frame = wire::encode_reply<lk::ReadStatus1>(
        1, {.temperature = 40, .voltage = 2405, .bus_current = -150, .motor_state = 0x10, .error_state = 8});
    ASSERT_TRUE(frame);
    EXPECT_EQ(bytes(*frame), (std::vector<std::uint8_t>{0x9A, 0x28, 0x65, 0x09, 0x6A, 0xFF, 0x10, 0x08}));
    EXPECT_DOUBLE_EQ(reading_of(spec_of("MF", "lk-2.35"), "read-status1", "voltage").physical(2405), 24.05);
}

TEST(RmdRows, LkAnswersClearErrorWithItsOwnByte)
{
    EXPECT_EQ(wire::encode_reply<lk::ClearError>(1, {}, line("lk-2.35").options())->data[0], 0x9B);
    EXPECT_EQ(wire::encode_reply<ClearError>(1, {}, line("rmd-2.35").options())->data[0], 0x9A);
}

TEST(RmdRows, LkSingleTurnAngleIsFourBytesWide)
{
    const auto frame = wire::encode_reply<lk::ReadSingleTurnAngle>(1, {.circle_angle = 0x00012345});
    EXPECT_EQ(bytes(*frame), (std::vector<std::uint8_t>{0x94, 0, 0, 0, 0x45, 0x23, 0x01, 0}));
}

TEST(RmdRows, Lk236SpeedCommandCarriesACurrentLimit)
{
    const auto frame = wire::encode_request(1, lk_2_36::SpeedClosedLoop{.iq = 1000, .speed = 9000});
    EXPECT_EQ(bytes(*frame), (std::vector<std::uint8_t>{0xA2, 0, 0xE8, 0x03, 0x28, 0x23, 0, 0}));
    const auto limited = wire::encode_request(1, lk::SpeedClosedLoopTorque{.iq = 1000, .speed = 9000});
    EXPECT_EQ(bytes(*limited), (std::vector<std::uint8_t>{0xAD, 0, 0xE8, 0x03, 0x28, 0x23, 0, 0}));
}

TEST(RmdRows, GyemsTorqueCommandsAre32AmperesAt2000)
{
    const Spec spec = spec_of("MG", "gyems-1.62");
    EXPECT_DOUBLE_EQ(reading_of(spec, "torque-closed-loop", "iq_control").physical(2000), 32.0);
    EXPECT_DOUBLE_EQ(reading_of(spec, "torque-closed-loop", "iq").physical(2048), 33.0);
    EXPECT_EQ(wire::encode_request(1, gyems::TorqueClosedLoop{.iq_control = 2001}).error().field, "iq_control");
}

TEST(RmdRows, MyActuatorStatesHaveTheirOwnLayout)
{
    const auto status = wire::encode_reply<myactuator::ReadStatus1>(
        1, {.temperature = 30, .brake_released = true, .voltage = 480, .error_state = 0x0104});
    EXPECT_EQ(bytes(*status), (std::vector<std::uint8_t>{0x9A, 0x1E, 0, 1, 0xE0, 0x01, 0x04, 0x01}));
    const auto angle = wire::encode_reply<myactuator::ReadMultiTurnAngle>(1, {.angle = -36000});
    EXPECT_EQ(bytes(*angle), (std::vector<std::uint8_t>{0x92, 0, 0, 0, 0x60, 0x73, 0xFF, 0xFF}));
}

} // namespace
} // namespace sinew::rmd
