#include "sinew/bus/conversation.hpp"
#include "sinew/bus/fake_family.hpp"

#include <array>
#include <gtest/gtest.h>
#include <vector>

/// When a conversation expects its answers.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};
constexpr Settings settings{.margin_at_first = 10ms, .margin_least = 1ms, .late_max = 50ms};

TEST(ConversationTime, AFewQuickAnswersDoNotMakeItImpatient)
{
    constexpr Line line{.can = false, .bit_rate = 100'000};
    Conversation conversation(framed, line, settings);
    const auto read = *wire::make_request(3, fake::Read{});
    Result result;
    TimePoint now{1s};
    const auto answered_at_once = [&] {
        conversation.begin({&read, 1}, {&result, 1});
        ASSERT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
        now += predict(line, read).total();
        conversation.received(std::array<std::uint8_t, 4>{0x55, 3, 1, 0}, now);
        ASSERT_TRUE(conversation.next(now).done);
    };
    for (int i = 0; i < 8; ++i) {
        answered_at_once();
        EXPECT_EQ(conversation.margin(), settings.margin_at_first) << "after " << i + 1;
    }
    answered_at_once();
    EXPECT_EQ(conversation.margin(), settings.margin_least);
}

TEST(ConversationTime, AnAnswerThatWasNotAskedForMayStillComeAndMakesTheNextOneDoubtful)
{
    Conversation conversation(framed, {.can = false, .bit_rate = 100'000}, settings);
    auto set = *wire::make_request(3, fake::Set{.value = 9});
    Result result;
    TimePoint now{1s};
    const auto exchange = [&](bool answered) {
        set.answered = answered;
        conversation.begin({&set, 1}, {&result, 1});
        ASSERT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
        now += 1ms;
        if (answered)
            conversation.received(std::array<std::uint8_t, 4>{0x55, 3, 2, 9}, now);
        ASSERT_TRUE(conversation.next(now).done);
    };
    exchange(true);
    EXPECT_FALSE(result.possibly_older);
    exchange(false);
    exchange(true);
    EXPECT_TRUE(result.possibly_older) << "it may be the one to the command that was to be silent";
    now += 2 * settings.late_max + settings.margin_most;
    exchange(true);
    EXPECT_FALSE(result.possibly_older);
}

TEST(ConversationTime, AnAnswerThatWasNotAskedForIsLateUntilItsDeviceHasHadItsTimeAndTheLink)
{
    for (const Duration late : {0ns, 1ns}) {
        Conversation conversation(framed, {.can = false, .bit_rate = 100'000}, settings);
        auto set = *wire::make_request(3, fake::Set{.value = 9}, {}, 2ms);
        set.answered = false;
        Result result;
        TimePoint now{1s};
        conversation.begin({&set, 1}, {&result, 1});
        ASSERT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
        now = conversation.next(now).deadline;
        ASSERT_TRUE(conversation.next(now).done);
        conversation.received(std::array<std::uint8_t, 4>{0x55, 3, 2, 9}, now + 2ms + settings.late_max + late);
        EXPECT_EQ(conversation.counters().late, late == 0ns ? 1U : 0U);
    }
}

TEST(ConversationTime, AnAnswerMayEndAfterThreeQuartersOfItsBitsAndNotBefore)
{
    const fake::FakeProtocol bare{true};
    const auto taken = [](const wire::Protocol& protocol, const wire::Request& request, Duration after,
                          const std::vector<std::uint8_t>& answer) {
        Conversation conversation(protocol, {.can = false, .bit_rate = 100'000}, settings);
        Result result;
        const TimePoint now{1s};
        conversation.begin({&request, 1}, {&result, 1});
        EXPECT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
        conversation.received(answer, now + after);
        return result.good;
    };
    const auto read = *wire::make_request(3, fake::Read{});
    EXPECT_TRUE(taken(framed, read, 600us, {0x55, 3, 1, 7})) << "of 800 µs both ways";
    EXPECT_FALSE(taken(framed, read, 600us - 1ns, {0x55, 3, 1, 7}));
    const auto bare_read = *wire::make_request(3, fake::BareRead{});
    EXPECT_TRUE(taken(bare, bare_read, 300us, {7, 7})) << "of 400 µs of the request";
    EXPECT_FALSE(taken(bare, bare_read, 300us - 1ns, {7, 7}));
}

TEST(ConversationTime, LongestIsEveryTryWithItsMargin)
{
    constexpr Line line{.can = false, .bit_rate = 100'000};
    const auto longest = [&](const wire::Request& request, Settings with) {
        return Conversation(framed, line, with).longest({&request, 1});
    };
    const auto read = *wire::make_request(3, fake::Read{}, {}, 2ms);
    auto set = *wire::make_request(3, fake::Set{}, {}, 2ms);
    const Duration once = 800us + 2ms + Settings{}.margin_most;
    EXPECT_EQ(longest(read, {.read_retries = 0}), once);
    EXPECT_EQ(longest(read, {.read_retries = -1}), once);
    EXPECT_EQ(longest(read, {.read_retries = 2}), 3 * once);
    EXPECT_EQ(longest(read, {.read_retries = 0, .double_read = true}), once) << "only bare ones are asked twice";
    EXPECT_EQ(longest(set, {.read_retries = 2}), once);
    EXPECT_EQ(longest(set, {.command_retries = 1}), 2 * once);
    set.answered = false;
    EXPECT_EQ(longest(set, {}), 400us);
    const std::array both{read, read};
    EXPECT_EQ(Conversation(framed, line, {.read_retries = 0}).longest(both), 2 * once);
}

TEST(ConversationTime, ADoubtfulAnswerTeachesNothing)
{
    constexpr Line line{.can = false, .bit_rate = 100'000};
    Conversation conversation(framed, line, settings);
    const auto read = *wire::make_request(3, fake::Read{});
    Result result;
    TimePoint now{1s};
    const auto ask = [&] {
        conversation.begin({&read, 1}, {&result, 1});
        EXPECT_EQ(conversation.next(now).transmit.size(), 1U);
        conversation.transmitted(1, now);
    };
    const auto answer = [&](Duration late) {
        now = result.due + late;
        conversation.received(std::array<std::uint8_t, 4>{0x55, 3, 1, 0}, now);
        EXPECT_TRUE(conversation.next(now).done);
    };
    for (int i = 0; i < 20; ++i) {
        ask();
        answer(0us);
    }
    ASSERT_EQ(conversation.margin(), settings.margin_least);
    conversation.distrust(now);
    ask();
    answer(900us);
    EXPECT_TRUE(result.possibly_older);
    EXPECT_EQ(conversation.margin(), settings.margin_least);
    now += 2 * settings.late_max;
    ask();
    answer(900us);
    EXPECT_FALSE(result.possibly_older);
    EXPECT_EQ(conversation.margin(), 1800us);
}

TEST(ConversationTime, AnAnswerInAFrameNeedsNoSecondOneToBeBelieved)
{
    constexpr Line line{.can = false, .bit_rate = 100'000};
    Conversation conversation(framed, line, {.double_read = true});
    const auto read = *wire::make_request(3, fake::Read{});
    Result result;
    conversation.begin({&read, 1}, {&result, 1});
    const TimePoint now{1s};
    ASSERT_EQ(conversation.next(now).transmit.size(), 1U);
    conversation.transmitted(1, now);
    conversation.received(std::array<std::uint8_t, 4>{0x55, 3, 1, 0}, now + predict(line, read).total());
    EXPECT_TRUE(result.good);
}

/// A CAN bus that carries so many exchanges before the answer of the last one.
class CanTime : public ::testing::Test
{
protected:
    void begin(std::initializer_list<int> ids)
    {
        requests_.clear();
        for (const int id : ids)
            requests_.push_back(*wire::make_request(id, fake::CanRead{}, {}, response));
        results_.assign(requests_.size(), {});
        conversation_.begin(requests_, results_);
    }
    /// How many frames go out.
    std::size_t send()
    {
        const std::size_t count = conversation_.next(now_).transmit.size();
        conversation_.transmitted(count, now_);
        return count;
    }
    void answer(unsigned id) { conversation_.received({.can_id = 0x100 + id, .size = 2, .data = {5, 1}}, now_); }
    Duration exchanges(int count) const { return count * predict(line, requests_.front()).wire() + response; }

    static constexpr Line line{.can = true, .bit_rate = 1'000'000};
    static constexpr Duration response = 300us;
    Conversation conversation_{framed, line, settings};
    std::vector<wire::Request> requests_;
    std::vector<Result> results_;
    TimePoint now_{1s};
};

TEST_F(CanTime, AnAnswerIsDueWhenTheWireHasCarriedWhatIsStillOutstanding)
{
    begin({1, 2, 3, 1});
    ASSERT_EQ(send(), 3U);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(results_[i].due - now_, exchanges(3));
    now_ += 5ms;
    answer(2);
    now_ += 1ms;
    answer(1);
    ASSERT_EQ(send(), 1U) << "the second one to device 1";
    EXPECT_EQ(results_[3].due - now_, exchanges(2)) << "its own, and that of device 3";
    answer(3);
    answer(1);
    ASSERT_TRUE(conversation_.next(now_).done);
    begin({2});
    ASSERT_EQ(send(), 1U);
    EXPECT_EQ(results_[0].due - now_, exchanges(1)) << "nothing is left of the exchange before";
}

TEST_F(CanTime, WhatWasAbandonedIsStillCarriedBeforeTheNext)
{
    begin({1, 2});
    ASSERT_EQ(send(), 2U);
    conversation_.abandon({.code = Errc::stopped}, now_);
    begin({3});
    ASSERT_EQ(send(), 1U);
    EXPECT_EQ(results_[0].due - now_, exchanges(3));
}

} // namespace
} // namespace sinew::bus
