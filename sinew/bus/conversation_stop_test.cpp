#include "sinew/bus/fake_talk.hpp"

#include <array>
#include <gtest/gtest.h>
#include <vector>

/// What ends before its time: by a stop, or because the link is gone.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;
using fake::settings;
using fake::Talk;

const fake::FakeProtocol framed{false};
const fake::FakeProtocol bare{true};

TEST(ConversationStop, EndsEveryRequestAtOnceWhileAStopIsOnItsWay)
{
    Talk talk(framed);
    const auto stop = *wire::make_request(9, fake::Set{});
    Result stopped;
    talk.conversation.begin_stop({&stop, 1}, {&stopped, 1});
    talk.ask(std::pair{1, fake::Read{}}, std::pair{2, fake::Read{}}, std::pair{3, fake::Read{}});
    for (std::size_t i = 0; i < talk.results.size(); ++i) {
        EXPECT_EQ(talk.results[i].error.code, Errc::stopped) << i;
        EXPECT_EQ(talk.results[i].error.id, static_cast<int>(i) + 1);
    }
    EXPECT_EQ(talk.sent(), stop.frame);
}

TEST(ConversationStop, EndsEveryStopThatCouldNotGoOutAnyMore)
{
    Talk talk(framed);
    const std::array stops = {*wire::make_request(8, fake::Set{}), *wire::make_request(9, fake::Set{})};
    std::array<Result, 2> stopped;
    talk.ask(std::pair{1, fake::Read{}});
    talk.sent();
    talk.conversation.begin_stop(stops, stopped);
    talk.conversation.abandon({.code = Errc::link_lost}, talk.now);
    for (std::size_t i = 0; i < stops.size(); ++i) {
        EXPECT_EQ(stopped[i].reply().error().code, Errc::link_lost) << i;
        EXPECT_EQ(stopped[i].error.id, stops[i].id);
    }
    EXPECT_FALSE(talk.conversation.busy());
}

TEST(ConversationStop, WhatBeginsWhileItsFramesAreOnTheWireDoesNotEndIt)
{
    Talk talk(framed);
    const auto stop = *wire::make_request(9, fake::Set{});
    Result stopped;
    talk.conversation.begin_stop({&stop, 1}, {&stopped, 1});
    EXPECT_EQ(talk.sent(), stop.frame);
    talk.ask(std::pair{1, fake::Read{}});
    EXPECT_EQ(talk.results[0].error.code, Errc::stopped);
    talk.hear({0x55, 9, 2, 0});
    EXPECT_TRUE(stopped.good);
    EXPECT_TRUE(talk.done());
    EXPECT_FALSE(talk.conversation.stopping());
}

TEST(ConversationStop, GoesOutInQuarantineAndOnlyOnce)
{
    Talk talk(bare);
    talk.conversation.distrust(talk.now);
    const auto stop = *wire::make_request(9, fake::BareRead{});
    Result stopped;
    talk.conversation.begin_stop({&stop, 1}, {&stopped, 1});
    EXPECT_EQ(talk.sent(), stop.frame);
    EXPECT_EQ(talk.deadline() - talk.now, 600us) << "as long as the wire needs, without a margin";
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    EXPECT_EQ(stopped.reply().error().code, Errc::timeout);
    EXPECT_FALSE(talk.conversation.busy());
}

TEST(ConversationStop, OnCanWaitsOnlyForWhatIsOutstanding)
{
    Talk talk(framed, true);
    talk.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}});
    talk.requests[0].response_time = 5ms;
    talk.requests[1].response_time = 1ms;
    const auto next = talk.conversation.next(talk.now);
    ASSERT_EQ(next.transmit.size(), 2U);
    talk.conversation.transmitted(2, talk.now);
    const auto stop = *wire::make_request(3, fake::CanRead{});
    Result stopped;
    talk.conversation.received({.can_id = 0x101, .size = 2, .data = {5, 11}}, talk.now);
    talk.conversation.begin_stop({&stop, 1}, {&stopped, 1});
    EXPECT_EQ(talk.deadline(), talk.results[1].due) << "device 1 has answered";
    EXPECT_FALSE(talk.sent());
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), stop.frame);
    EXPECT_EQ(talk.results[1].error.code, Errc::stopped);
}

TEST(ConversationStop, TheAnswerToWhatWasAbandonedMayComeAsLateAsAny)
{
    for (const Duration late : {0ns, 1ns}) {
        Talk talk(framed);
        talk.ask(std::pair{3, fake::Read{}}, std::pair{4, fake::Read{}});
        talk.sent();
        const TimePoint deadline = talk.deadline();
        talk.conversation.abandon({.code = Errc::stopped}, talk.now);
        EXPECT_EQ(talk.results[0].error.code, Errc::stopped);
        talk.now = deadline + settings.late_max + late;
        talk.hear({0x55, 3, 1, 42});
        EXPECT_EQ(talk.conversation.counters(3).late, late == 0ns ? 1U : 0U);
    }
}

TEST(ConversationStop, WhatHasNotGoneOutOwesNoAnswer)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}}, std::pair{4, fake::Read{}});
    talk.sent();
    talk.conversation.abandon({.code = Errc::stopped}, talk.now);
    talk.hear({0x55, 4, 1, 42});
    EXPECT_EQ(talk.conversation.counters().late, 0U);
    EXPECT_EQ(talk.conversation.counters().strays, 4U);
}

TEST(ConversationStop, AbandonsWhatIsNotDone)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}}, std::pair{4, fake::Read{}});
    talk.sent();
    talk.hear({0x55, 3, 1, 0});
    talk.conversation.abandon({.code = Errc::link_lost}, talk.now);
    EXPECT_TRUE(talk.results[0].good);
    EXPECT_EQ(talk.results[1].reply().error().code, Errc::link_lost);
    EXPECT_FALSE(talk.conversation.busy());
}

} // namespace
} // namespace sinew::bus
