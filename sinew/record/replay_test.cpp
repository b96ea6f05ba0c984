#include "sinew/record/replay.hpp"

#include "sinew/bus/bus.hpp"
#include "sinew/record/answers.hpp"
#include "sinew/record/file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace sinew::record {
namespace {

using wire::Direction;
using namespace std::chrono_literals;

Captured can(Duration at, std::optional<Direction> direction, std::uint32_t id, std::vector<std::uint8_t> data)
{
    Captured out{.at = Time{at}, .bus = "legs", .direction = direction, .kind = Captured::Kind::can};
    out.frame = {.can_id = id, .size = static_cast<std::uint8_t>(data.size())};
    std::copy(data.begin(), data.end(), out.frame.data.begin());
    return out;
}

Captured bytes(Duration at, std::optional<Direction> direction, std::vector<std::uint8_t> data)
{
    return {.at = Time{at}, .bus = "left", .direction = direction, .bytes = std::move(data)};
}

constexpr auto asked = Direction::request, said = Direction::reply;
constexpr std::uint8_t read[] = {0x9C};

TEST(Answers, EveryTimeOfARequestHasItsOwnAnswerAndTheyEnd)
{
    Answers answers;
    for (const auto& one : {bytes(1ms, asked, {0x9C}), bytes(2ms, said, {1}), bytes(3ms, said, {2}),
                            bytes(5ms, asked, {7}), bytes(6ms, asked, {0x9C}), bytes(9ms, said, {3})})
        answers.add(one);
    const auto first = answers.next(0, read, false);
    ASSERT_EQ(first.size(), 2U);
    EXPECT_EQ(first[0].after, 1ms);
    EXPECT_EQ(first[1].said.bytes, std::vector<std::uint8_t>{2});
    const auto second = answers.next(0, read, false);
    ASSERT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0].after, 3ms);
    EXPECT_TRUE(answers.next(0, read, false).empty());
    EXPECT_EQ(answers.next(0, read, true).size(), 2U) << "in a loop they begin again";
    const std::uint8_t other[] = {8}, silent[] = {7};
    EXPECT_TRUE(answers.next(0, other, true).empty());
    EXPECT_TRUE(answers.next(0, silent, true).empty());
}

TEST(Answers, WhatWasAskedOnlyOnceIsAnsweredSoAgainAndIsNothingNew)
{
    Answers answers;
    for (const auto& one : {bytes(1ms, asked, {0x9C}), bytes(2ms, said, {1}), bytes(3ms, asked, {7}),
                            bytes(4ms, said, {2}), bytes(5ms, asked, {7})})
        answers.add(one);
    for (int i = 0; i < 3; ++i) {
        const auto setting = answers.next(0, read, false);
        ASSERT_EQ(setting.size(), 1U);
        EXPECT_EQ(setting[0].said.bytes, std::vector<std::uint8_t>{1});
        EXPECT_EQ(answers.given(), 1U);
    }
    const std::uint8_t state[] = {7};
    EXPECT_EQ(answers.next(0, state, false).size(), 1U);
    EXPECT_TRUE(answers.next(0, state, false).empty()) << "it was asked, and there was no answer";
    EXPECT_EQ(answers.given(), 3U);
    EXPECT_TRUE(answers.next(0, state, false).empty());
    EXPECT_EQ(answers.given(), 3U) << "that was nothing new";
}

TEST(Answers, OnCanAnAnswerBelongsToTheRequestOfItsDeviceAndCommand)
{
    Answers answers;
    for (const auto& one :
         {can(1ms, asked, 0x141, {0x9C}), can(1ms, asked, 0x142, {0x9C}), can(1ms, asked, 0x142, {0x9A}),
          can(2ms, said, 0x142, {0x9C, 2}), can(3ms, said, 0x141, {0x9C, 1}), can(4ms, said, 0x242, {0x9A, 3})})
        answers.add(one);
    EXPECT_EQ(answers.next(0x141, read, false)[0].said.frame.data[1], 1);
    EXPECT_EQ(answers.next(0x142, read, false)[0].said.frame.data[1], 2);
    const std::uint8_t status[] = {0x9A};
    EXPECT_EQ(answers.next(0x142, status, false)[0].said.frame.can_id, 0x242U) << "another base for replies";
}

TEST(Answers, ARequestForSeveralDevicesHasTheAnswersOfAll)
{
    Answers answers;
    answers.add(can(1ms, asked, 0x280, {0xA1}));
    for (std::uint32_t id = 0x141; id <= 0x144; ++id)
        answers.add(can(2ms, said, id, {0xA1, 1}));
    const std::uint8_t torque[] = {0xA1};
    EXPECT_EQ(answers.next(0x280, torque, false).size(), 4U);
}

TEST(Answers, OnCanTheOrderTellsWhoSaidWhatWhereTheRecordingDoesNot)
{
    Answers answers;
    for (const auto& one : {can(1ms, {}, 0x141, {0x9C}), can(2ms, {}, 0x141, {0x9C, 5}), can(3ms, {}, 0x141, {0x9C}),
                            can(900ms, {}, 0x141, {0x9C})})
        answers.add(one);
    EXPECT_EQ(answers.next(0x141, read, false)[0].said.frame.data[1], 5);
    EXPECT_TRUE(answers.next(0x141, read, false).empty()) << "what comes much later is another request";
}

class ReplayTest : public testing::Test
{
protected:
    ReplayTest() : path_(std::filesystem::temp_directory_path() / fmt::format("sinew-replay-{}.mcap", ::getpid())) {}
    ~ReplayTest() override { std::filesystem::remove(path_); }

    void write(const std::vector<Captured>& all) const
    {
        auto file = FileWriter::create(path_);
        for (const auto& one : all)
            ASSERT_TRUE(file->add(one));
        ASSERT_TRUE(file->finish());
    }
    std::string uri(std::string_view bus) const { return fmt::format("replay:{}#{}", path_.string(), bus); }

    std::filesystem::path path_;
    link::Links links_;
    Replays replays_;
};

TEST_F(ReplayTest, ALinkAnswersAfterTheTimeOfTheRecordingAndKeepsItsTime)
{
    add(links_, replays_);
    write({bytes(5s, asked, {0x9C}), bytes(5003ms, said, {1, 2}), bytes(5100ms, asked, {0x9C}),
           can(6s, asked, 0x141, {0x9C}), can(6001ms, said, 0x141, {0x9C, 9})});
    auto* clock = *replays_.clock_for(uri("left"));
    EXPECT_EQ(clock->now().time_since_epoch(), 5s);
    auto left = links_.open(uri("left"), *clock);
    ASSERT_TRUE(left) << to_sentence(left.error());
    auto& link = *std::get<std::unique_ptr<link::ByteLink>>(*left);
    ASSERT_TRUE(link.write(read));
    std::uint8_t buffer[8];
    EXPECT_EQ(link.read(buffer)->count, 0U);
    clock->wait({}, TimePoint::max());
    EXPECT_EQ(clock->now().time_since_epoch(), 5003ms);
    EXPECT_EQ(link.read(buffer)->count, 2U);
    ASSERT_TRUE(link.write(read));
    clock->wait({}, TimePoint{6s});
    EXPECT_EQ(clock->now().time_since_epoch(), 6s) << "it was not answered then";
    EXPECT_EQ(replays_.given(), 2U);

    auto legs = links_.open(uri("legs"), *clock);
    ASSERT_TRUE(legs);
    auto& frames = *std::get<std::unique_ptr<link::CanLink>>(*legs);
    const wire::Frame request{.can_id = 0x141, .size = 1, .data = {0x9C}};
    ASSERT_TRUE(frames.write({&request, 1}));
    clock->wait({}, TimePoint::max());
    wire::Frame reply;
    EXPECT_EQ(frames.read({&reply, 1})->count, 1U);
    EXPECT_EQ(reply.data[1], 9);
}

TEST_F(ReplayTest, SaysWhatCannotBeReplayed)
{
    add(links_, replays_);
    link::RealClock real;
    EXPECT_FALSE(replays_.clock_for("replay:/is/not/here.mcap#left"));
    write({bytes(5s, {}, {0x9C}), bytes(6s, {}, {1})});
    auto* clock = *replays_.clock_for(uri("left"));
    const auto why = [&](const std::string& uri, link::Clock& with) {
        const auto opened = links_.open(uri, with);
        return opened ? std::string{} : to_sentence(opened.error());
    };
    EXPECT_NE(why(uri("left"), *clock).find("does not tell who sent what"), std::string::npos);
    EXPECT_NE(why(uri("right"), *clock).find("it has left"), std::string::npos);
    EXPECT_NE(why(uri("left"), real).find("time of its own"), std::string::npos);
    EXPECT_NE(why(fmt::format("replay:{}?loop=maybe#left", path_.string()), *clock).find("on or off"),
              std::string::npos);
}

} // namespace
} // namespace sinew::record
