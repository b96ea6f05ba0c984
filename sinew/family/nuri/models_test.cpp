#include "sinew/family/nuri/models.hpp"

#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/lines.hpp"
#include "sinew/wire/codec.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace sinew::nuri {
namespace {

const wire::Profile& rsa = profiles()[0].line;
const wire::Profile& mc_line = profiles()[1].line;

std::vector<std::uint8_t> bytes(const wire::Frame& frame)
{
    return {frame.data.begin(), frame.data.begin() + frame.size};
}

TEST(NuriLines, AreTheDocumentAndMc)
{
    ASSERT_EQ(profiles().size(), 2U);
    EXPECT_EQ(rsa.name, "rsa");
    EXPECT_EQ(mc_line.name, "mc");
    EXPECT_EQ(rsa.messages.size(), 34U);
    EXPECT_EQ(find_model("RSA")->line, "rsa");
    EXPECT_EQ(find_model("mc")->line, "mc");
    EXPECT_EQ(find_model("SB"), find_model("RSA"));
    EXPECT_EQ(find_model("SM"), nullptr) << "its two published maps disagree";
}

TEST(NuriLines, TheSameNumbersMeanOtherThingsOnMc)
{
    const auto name_of = [](const wire::Profile& line, int opcode) -> std::string_view {
        for (const wire::MessageInfo* message : line.messages)
            if (message->info.opcode == opcode)
                return message->name();
        return "";
    };
    EXPECT_EQ(name_of(rsa, 0x0A), "set-control-on-off");
    EXPECT_EQ(name_of(mc_line, 0x0A), "set-resolution");
    EXPECT_EQ(name_of(rsa, 0x0B), "set-position-control-mode");
    EXPECT_EQ(name_of(mc_line, 0x0B), "set-external-gear-ratio");
    EXPECT_EQ(name_of(rsa, 0x0C), "reset-position");
    EXPECT_EQ(name_of(mc_line, 0x0C), "set-control-on-off");
    EXPECT_EQ(name_of(rsa, 0x0D), "factory-reset");
    EXPECT_EQ(name_of(mc_line, 0x0D), "set-position-control-mode");
    EXPECT_EQ(name_of(rsa, 0x0F), "set-control-direction");
    EXPECT_EQ(name_of(mc_line, 0x0F), "reset-position");
    EXPECT_EQ(name_of(rsa, 0x10), "");
    EXPECT_EQ(name_of(mc_line, 0x10), "factory-reset");
    for (int opcode = 1; opcode <= 8; ++opcode)
        EXPECT_EQ(name_of(rsa, opcode), name_of(mc_line, opcode)) << opcode;
}

TEST(NuriLines, WhatOneLineHasTheOtherRefuses)
{
    EXPECT_EQ(rsa.find("set-resolution"), nullptr);
    EXPECT_EQ(rsa.find("request-rated-speed-feedback"), nullptr);
    EXPECT_FALSE(mc_line.has(wire::info_of<FactoryReset>));
    EXPECT_FALSE(mc_line.has(wire::info_of<SetControlOnOff>));
    EXPECT_TRUE(mc_line.has(wire::info_of<mc::SetControlOnOff>));
}

TEST(NuriLines, EveryAnsweredRequestHasItsReplyInTheList)
{
    for (const Profile& profile : profiles())
        for (const wire::MessageInfo* message : profile.line.messages) {
            if (!message->request.exists() || !message->reply.exists())
                continue;
            const auto is_reply = [&](const wire::MessageInfo* other) {
                return !other->request.exists() && other->reply.opcode == message->reply.opcode;
            };
            EXPECT_TRUE(std::ranges::any_of(profile.line.messages, is_reply)) << message->name();
        }
}

TEST(NuriRows, McSettingsAreEncodedWithTheirOwnModes)
{
    EXPECT_EQ(bytes(*wire::encode_request(1, mc::SetControlOnOff{Control::off})),
              (std::vector<std::uint8_t>{0xFF, 0xFE, 0x01, 0x03, 0xEE, 0x0C, 0x01}));
    EXPECT_EQ(bytes(*wire::encode_request(1, mc::SetResolution{4096})),
              (std::vector<std::uint8_t>{0xFF, 0xFE, 0x01, 0x04, 0xE0, 0x0A, 0x10, 0x00}));
    const auto reply = wire::encode_reply<mc::RequestGearRatioFeedback>(1, {.gear_ratio = 300});
    EXPECT_EQ(bytes(*reply), (std::vector<std::uint8_t>{0xFF, 0xFE, 0x01, 0x04, 0xF5, 0xD8, 0x01, 0x2C}));
}

TEST(NuriRows, FramesOfBothLinesAreFoundOnTheWire)
{
    // Mode 0x0A is one byte longer on MC; no line has it with nine bytes.
    for (const auto& frame :
         {wire::encode_request(1, SetControlOnOff{}), wire::encode_request(1, mc::SetResolution{})}) {
        const wire::Scan scan = protocol().find_request(std::span(frame->data).first(frame->size), false);
        EXPECT_EQ(scan.skip, 0U);
        EXPECT_EQ(scan.size, frame->size);
    }
    const std::array<std::uint8_t, 9> longer{0xFF, 0xFE, 0x01, 0x05, 0xEF, 0x0A, 0x00, 0x00, 0x00};
    EXPECT_EQ(protocol().find_request(longer, true).size, 0U);
}

TEST(NuriRows, AFrameIsNamedByTheLineOfItsDevice)
{
    const auto frame = wire::encode_request(1, mc::SetControlOnOff{Control::off});
    EXPECT_EQ(protocol().identify(*frame, wire::Direction::request, mc_line)->name(), "set-control-on-off");
    const auto bare = wire::encode_request(1, ResetPosition{});
    EXPECT_EQ(protocol().identify(*bare, wire::Direction::request, rsa)->name(), "reset-position");
    EXPECT_EQ(protocol().identify(*bare, wire::Direction::request, mc_line), nullptr) << "too short for 0x0C of MC";
}

TEST(NuriProfile, ResponseTimeIsThatOfTheDevice)
{
    Profile profile = profiles().front();
    EXPECT_EQ(profile.response_time(), std::chrono::microseconds{100});
    profile.response_time_us = 25'400;
    EXPECT_EQ(profile.response_time(), std::chrono::microseconds{25'400});
}

} // namespace
} // namespace sinew::nuri
