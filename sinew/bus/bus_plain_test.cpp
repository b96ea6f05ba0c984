#include "sinew/bus/bus.hpp"
#include "sinew/bus/fake_scripted_for_tests.hpp"

#include <array>
#include <gtest/gtest.h>
#include <span>
#include <vector>

/// One request that one device is to answer: what its usual way does to the link, and where it has to leave it.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;
using fake::bytes_of;

using Bytes = fake::Scripted<link::ByteLink>;
using Frames = fake::Scripted<link::CanLink>;

const fake::FakeProtocol framed{false};
const fake::FakeProtocol bare{true};

wire::Frame can_answer(unsigned id, std::uint8_t value = 1)
{
    return {.can_id = 0x100 + id, .size = 2, .data = {5, value}};
}

TEST(BusPlain, IsOneWriteOneWaitAndOneRead)
{
    Bytes line(framed);
    line.link.answers = {{0x55, 3, 1, 42}};
    EXPECT_EQ(line.bus.call(3, fake::Read{})->value, 42);
    EXPECT_EQ(line.link.writes, 1);
    EXPECT_EQ(line.clock.waits, 1);
    EXPECT_EQ(line.link.reads, 1);
}

TEST(BusPlain, AnAnswerThatIsReadLongAfterItsDeadlineHadComeByThen)
{
    const auto read = *wire::make_request(3, fake::Read{});
    for (const std::size_t count : {1U, 2U}) { // its usual way, and the other
        Bytes line(framed);
        line.link.answers = {{0x55, 3, 1, 42}, {0x55, 3, 1, 42}};
        line.link.reads_late_by = 3s;
        const std::array requests{read, read};
        std::array<Result, 2> results;
        ASSERT_TRUE(line.bus.exchange(std::span(requests).first(count), std::span(results).first(count)).has_value());
        for (const auto& result : std::span(results).first(count)) {
            EXPECT_TRUE(result.good);
            EXPECT_EQ(result.at, result.deadline);
        }
    }
}

TEST(BusPlain, ReadsOnceMoreBeforeItWhereRepliesAreBare)
{
    Bytes line(bare);
    line.link.answers = {{8, 8}};
    EXPECT_EQ(line.bus.call(3, fake::BareRead{})->value, 8);
    EXPECT_EQ(line.link.writes, 1);
    EXPECT_EQ(line.clock.waits, 1);
    EXPECT_EQ(line.link.reads, 2);
}

TEST(BusPlain, OneByteThatNobodyAskedForKeepsABareReadWaitingUntilTheLineIsSilent)
{
    for (const std::vector<std::uint8_t>& noise : {std::vector<std::uint8_t>{9}, {9, 9}, {9, 9, 9}}) {
        Bytes line(bare);
        const TimePoint before = line.clock.now();
        line.link.pieces = {{noise, before}};
        line.link.answers = {{3, 3}, {8, 8}};
        const auto read = *wire::make_request(3, fake::BareRead{});
        std::array<Result, 2> results;
        results[1].tries = 7;
        ASSERT_TRUE(line.bus.exchange({&read, 1}, std::span(results).first(1)).has_value());
        ASSERT_EQ(line.link.written.size(), 2U) << noise.size();
        EXPECT_EQ(line.link.written[0], bytes_of(*wire::encode_request(3, fake::BarePing{})));
        EXPECT_GE(results[0].sent_at - before, Settings{}.late_max);
        EXPECT_EQ(results[0].answer().data[0], 8);
        EXPECT_EQ(results[1].tries, 7) << "the result of somebody else";
        EXPECT_FALSE(line.bus.conversation().busy());
    }
}

TEST(BusPlain, BytesBeforeItAreNotWrittenIntoTheResultOfAnExchangeThatIsOver)
{
    Bytes line(bare);
    const auto read = *wire::make_request(3, fake::BareRead{});
    const std::array requests{read, read};
    std::array<Result, 2> results;
    line.link.answers = {{7, 7}, {8, 8}, {3, 3}, {9, 9}};
    ASSERT_TRUE(line.bus.exchange(requests, results).has_value());
    ASSERT_TRUE(results[1].good);
    for (Result& result : results) { // their owner does with them what he likes
        result = {};
        result.stage = Result::Stage::sent;
    }
    line.link.pieces = {{{6, 6}, line.clock.now()}};
    EXPECT_EQ(line.bus.call(3, fake::BareRead{})->value, 9);
    for (const Result& result : results)
        EXPECT_EQ(result.stage, Result::Stage::sent);
}

TEST(BusPlain, TheRestOfARequestGoesOutBeforeItsAnswerIsWaitedFor)
{
    for (const std::size_t part : {0U, 1U, 3U}) {
        Bytes line(framed);
        line.link.rooms = {part};
        line.link.answers = {{0x55, 3, 1, 42}};
        const auto number = line.bus.call(3, fake::Read{});
        ASSERT_TRUE(number.has_value()) << part << " bytes fitted at first";
        EXPECT_EQ(line.link.all_written(), bytes_of(*wire::encode_request(3, fake::Read{})));
        EXPECT_EQ(line.bus.conversation().counters().requests, 1U);
        EXPECT_EQ(line.bus.conversation().counters().timeouts, 0U);
    }
}

TEST(BusPlain, WhatStandsInAResultFromBeforeMakesNoAnswer)
{
    Bytes line(framed);
    const auto read = *wire::make_request(3, fake::Read{});
    Result result;
    line.link.answers = {{0x55, 3, 1, 42}, {0x55, 9, 1, 7}};
    ASSERT_TRUE(line.bus.exchange({&read, 1}, {&result, 1}).has_value());
    EXPECT_EQ(result.reply_count, 1);
    EXPECT_EQ(result.tries, 1);
    result.replies.fill(result.replies[0]);
    ASSERT_TRUE(line.bus.exchange({&read, 1}, {&result, 1}).has_value());
    EXPECT_FALSE(result.good) << "another device answered, twice nobody else";
}

TEST(BusPlain, EndsAnExchangeThatIsStillRunning)
{
    Bytes line(framed);
    const auto set = *wire::make_request(3, fake::Set{.value = 9});
    Result result;
    line.bus.start({&set, 1}, {&result, 1});
    ASSERT_FALSE(line.bus.work());
    line.link.answers = {{0x55, 4, 1, 42}};
    EXPECT_TRUE(line.bus.call(4, fake::Read{}).has_value());
    EXPECT_EQ(result.error.code, Errc::stopped);
}

TEST(BusPlain, OnCanAsksOneAloneWhereAnExchangeIsStillRunning)
{
    Frames line(framed);
    const std::array requests{*wire::make_request(3, fake::CanRead{}), *wire::make_request(4, fake::CanRead{}),
                              *wire::make_request(5, fake::CanRead{})};
    std::array<Result, 3> results;
    line.bus.start({requests.data(), 1}, std::span(results).first(1));
    ASSERT_FALSE(line.bus.work());
    line.link.answers = {{can_answer(4)}};
    ASSERT_TRUE(line.bus.exchange(std::span(requests).subspan(1, 1), std::span(results).subspan(1, 1)).has_value());
    EXPECT_TRUE(results[1].good);
    EXPECT_EQ(line.link.all_written(), (std::vector{requests[0].frame, requests[1].frame}));
    EXPECT_EQ(results[2].stage, Result::Stage::waiting) << "the result of somebody else";
}

TEST(BusPlain, OnCanHandsOverOneFrame)
{
    Frames line(framed);
    line.link.answers = {{can_answer(3)}};
    EXPECT_TRUE(line.bus.call(3, fake::CanRead{}).has_value());
    EXPECT_EQ(line.link.all_written().size(), 1U);
    EXPECT_EQ(line.clock.waits, 1);
    EXPECT_EQ(line.link.reads, 1);
}

TEST(BusPlain, OnCanAFrameThatFoundNoRoomIsHandedOverAgainAndNotWaitedFor)
{
    Frames line(framed);
    line.link.rooms = {0, 0};
    line.link.answers = {{can_answer(3)}};
    EXPECT_TRUE(line.bus.call(3, fake::CanRead{}).has_value());
    EXPECT_EQ(line.link.all_written().size(), 1U);
    EXPECT_EQ(line.bus.conversation().counters().requests, 1U);
    EXPECT_EQ(line.bus.conversation().counters().timeouts, 0U);
    EXPECT_EQ(line.clock.waits, 2) << "it spun";
}

TEST(BusPlain, OnCanAnAnswerIsNotTakenForThatOfTheNextCall)
{
    Frames line(framed);
    line.link.answers = {{can_answer(3)}};
    ASSERT_TRUE(line.bus.call(3, fake::CanRead{}).has_value());
    const auto second = line.bus.call(3, fake::CanRead{});
    ASSERT_FALSE(second.has_value()) << "nobody answered";
    EXPECT_EQ(second.error().code, Errc::timeout);
}

TEST(BusPlain, OnCanAFrameBehindTheAnswerIsAStray)
{
    Frames line(framed);
    line.link.answers = {{can_answer(3), can_answer(9)}};
    EXPECT_TRUE(line.bus.call(3, fake::CanRead{}).has_value());
    EXPECT_EQ(line.bus.conversation().counters().strays, 1U);
}

TEST(BusPlain, OnCanWaitsForWhatWasAbandonedAsWell)
{
    for (const int count : {1, 2, 3}) {
        Frames line(framed);
        std::vector<wire::Request> abandoned;
        for (int id = 1; id <= count; ++id)
            abandoned.push_back(*wire::make_request(id, fake::CanRead{}));
        std::vector<Result> results(abandoned.size());
        line.bus.start(abandoned, results);
        ASSERT_FALSE(line.bus.work());
        line.bus.start({}, {});
        line.link.answers = {{can_answer(9)}};
        const auto read = *wire::make_request(9, fake::CanRead{});
        Result result;
        ASSERT_TRUE(line.bus.exchange({&read, 1}, {&result, 1}).has_value());
        EXPECT_EQ(result.due - result.sent_at, (count + 1) * predict(line.bus.conversation().line(), read).wire());
    }
}

TEST(BusPlain, ACommandThatNobodyAnswersEndsWithItsBits)
{
    Bytes line(framed);
    auto set = *wire::make_request(3, fake::Set{.value = 9});
    set.answered = false;
    Result result;
    EXPECT_TRUE(line.bus.exchange({&set, 1}, {&result, 1}).has_value());
    EXPECT_TRUE(result.good);
    EXPECT_EQ(line.clock.now().time_since_epoch(), 1s + 400us);
}

} // namespace
} // namespace sinew::bus
