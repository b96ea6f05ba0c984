#include "sinew/bus/fake_talk.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <vector>

namespace sinew::bus {
namespace {

using namespace std::chrono_literals;
using fake::FakeProtocol;
using fake::settings;
using fake::Talk;

const FakeProtocol framed{false};

TEST(Conversation, CountsTheLongestRoundTripsInTheLastBucket)
{
    EXPECT_EQ(Counters::bucket_of(0us), 0U);
    EXPECT_EQ(Counters::bucket_of(3us), 1U);
    EXPECT_EQ(Counters::bucket_of(std::chrono::microseconds(1 << 20)), Counters::buckets - 1);
    EXPECT_EQ(Counters::bucket_of(1h), Counters::buckets - 1);
}

TEST(Conversation, AResultThatIsUsedAgainHasNoAnswerOfBefore)
{
    Result result;
    result.replies[0] = *wire::encode_request(3, fake::Read{});
    result.reply_count = 1;
    EXPECT_EQ(result.answer(), result.replies[0]);
    result.reset();
    EXPECT_EQ(result.answer(), wire::Frame{});
}

TEST(Conversation, CountsDeviceNoughtForItselfAndIdsThatNobodyHasTogether)
{
    Talk talk(framed);
    talk.ask(std::pair{0, fake::Read{}});
    talk.sent();
    EXPECT_EQ(talk.conversation.counters(0).requests, 1U);
    EXPECT_EQ(talk.conversation.counters(-1).requests, 0U);
    EXPECT_EQ(&talk.conversation.counters(-1), &talk.conversation.counters(256));
}

TEST(Conversation, HasCountedNothingAtFirst)
{
    const Counters none = Talk(framed).conversation.counters();
    for (const std::uint64_t count : {none.requests, none.replies, none.timeouts, none.retries, none.late, none.strays,
                                      none.bad_checksums, none.echoes, none.disagreements, none.quarantines})
        EXPECT_EQ(count, 0U);
}

TEST(Conversation, SendsARequestAndTakesItsAnswer)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}});
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::Read{}));
    EXPECT_FALSE(talk.done());
    talk.hear({0x55, 3, 1, 42});
    EXPECT_TRUE(talk.done());
    EXPECT_EQ(talk.results[0].reply()->data[3], 42);
}

TEST(Conversation, TimesOutAfterTheBitsBothWaysTheResponseTimeAndTheMargin)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Set{}});
    talk.requests[0].response_time = 2ms;
    talk.sent();
    EXPECT_EQ(talk.deadline() - talk.now, 2 * 4 * 100us + 2ms + 10ms);
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    const auto reply = talk.results[0].reply();
    ASSERT_FALSE(reply.has_value());
    EXPECT_EQ(reply.error().code, Errc::timeout);
    EXPECT_EQ(reply.error().id, 3);
    EXPECT_EQ(reply.error().elapsed, 12'800us);
}

TEST(Conversation, RepeatsAReadButNeverACommand)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}}, std::pair{4, fake::Set{}});
    EXPECT_TRUE(talk.sent());
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::Read{})) << "the read once more";
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(4, fake::Set{}));
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done()) << "the command only once";
    EXPECT_EQ(talk.conversation.counters(3).retries, 1U);
    EXPECT_EQ(talk.conversation.counters(4).retries, 0U);
    EXPECT_EQ(talk.conversation.counters().timeouts, 3U);
}

TEST(Conversation, TheAnswerToASecondTryIsTheAnswer)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}});
    talk.sent();
    talk.now = talk.deadline();
    ASSERT_TRUE(talk.sent());
    talk.hear({0x55, 3, 1, 42});
    ASSERT_TRUE(talk.done());
    EXPECT_EQ(talk.results[0].reply_count, 1);
    EXPECT_EQ(talk.results[0].reply()->data[3], 42);
    EXPECT_FALSE(talk.conversation.busy());
}

TEST(Conversation, TakesNoAnswerOfAnotherDeviceOrMessage)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}});
    talk.sent();
    talk.hear({0x55, 4, 1, 42});
    talk.hear({0x55, 3, 2, 42});
    EXPECT_FALSE(talk.done());
    talk.hear({0x55, 3, 1, 7});
    EXPECT_TRUE(talk.done());
    EXPECT_EQ(talk.results[0].reply()->data[3], 7);
    EXPECT_EQ(talk.conversation.counters().strays, 8U);
}

TEST(Conversation, TakesAnAnswerInAnyPieces)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}});
    talk.sent();
    for (const int byte : {0x55, 3, 1})
        talk.hear({static_cast<std::uint8_t>(byte)});
    EXPECT_FALSE(talk.done());
    talk.hear({9});
    EXPECT_TRUE(talk.done());
}

TEST(Conversation, IsDoneWithAnUnansweredRequestWhenItsBitsAreOut)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Set{}}, std::pair{4, fake::Set{}});
    for (auto& request : talk.requests)
        request.answered = false;
    talk.sent();
    EXPECT_EQ(talk.deadline() - talk.now, 400us);
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(4, fake::Set{}));
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    EXPECT_TRUE(talk.results[0].good && talk.results[1].good);
}

TEST(Conversation, CountsALateAnswerAndDoesNotHandItOut)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Set{}});
    talk.sent();
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    talk.now += 5ms;
    talk.hear({0x55, 3, 2, 1});
    EXPECT_EQ(talk.conversation.counters(3).late, 1U);
    EXPECT_EQ(talk.conversation.counters().strays, 0U);
}

TEST(Conversation, MarksAnAnswerThatMayBelongToAnEarlierIdenticalRequest)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Set{}});
    talk.sent();
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    talk.ask(std::pair{3, fake::Set{}});
    talk.sent();
    talk.now += 1ms;
    talk.hear({0x55, 3, 2, 1});
    EXPECT_TRUE(talk.results[0].good && talk.results[0].possibly_older);
    talk.now += 60ms;
    talk.ask(std::pair{3, fake::Set{}});
    talk.sent();
    talk.hear({0x55, 3, 2, 1});
    EXPECT_FALSE(talk.results[0].possibly_older);
}

TEST(Conversation, DropsWhatIsBufferedOnce)
{
    Talk talk(framed);
    talk.hear({0x55, 3});
    talk.conversation.distrust(talk.now);
    talk.conversation.distrust(talk.now);
    EXPECT_EQ(talk.conversation.counters().strays, 2U);
}

TEST(Conversation, SendsAllFramesOnCanAtOnceButOnePerIdentifier)
{
    Talk talk(framed, true);
    talk.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}}, std::pair{1, fake::CanRead{}});
    EXPECT_EQ(talk.sent()->can_id, 0x101U);
    EXPECT_EQ(talk.sent()->can_id, 0x102U);
    EXPECT_FALSE(talk.sent().has_value()) << "0x101 is outstanding";
    talk.conversation.received({.can_id = 0x102, .size = 2, .data = {5, 22}}, talk.now);
    EXPECT_FALSE(talk.sent().has_value());
    talk.conversation.received({.can_id = 0x101, .size = 2, .data = {5, 11}}, talk.now);
    EXPECT_EQ(talk.sent()->can_id, 0x101U);
    talk.conversation.received({.can_id = 0x101, .size = 2, .data = {5, 12}}, talk.now);
    EXPECT_TRUE(talk.done());
    EXPECT_EQ(talk.results[0].reply()->data[1], 11);
    EXPECT_EQ(talk.results[1].reply()->data[1], 22);
    EXPECT_EQ(talk.results[2].reply()->data[1], 12);
}

TEST(Conversation, FindsWhoseAnswerItIsOnCanInWhateverOrderTheyCome)
{
    Talk talk(framed, true);
    std::array asked{1, 2, 3};
    do {
        std::array answering{1, 2, 3};
        do {
            talk.ask(std::pair{asked[0], fake::CanRead{}}, std::pair{asked[1], fake::CanRead{}},
                     std::pair{asked[2], fake::CanRead{}});
            while (talk.sent()) {
            }
            for (const int id : answering)
                talk.conversation.received({.can_id = 0x100U + static_cast<unsigned>(id),
                                            .size = 2,
                                            .data = {5, static_cast<std::uint8_t>(10 * id)}},
                                           talk.now);
            ASSERT_TRUE(talk.done());
            for (std::size_t i = 0; i < asked.size(); ++i)
                EXPECT_EQ(talk.results[i].reply()->data[1], 10 * asked[i]);
        } while (std::ranges::next_permutation(answering).found);
    } while (std::ranges::next_permutation(asked).found);
    EXPECT_EQ(talk.conversation.counters().strays, 0U);
}

TEST(Conversation, LearnsItsMarginFromTheSlowestAnswers)
{
    Talk talk(framed);
    for (int i = 0; i < 10; ++i) {
        talk.ask(std::pair{3, fake::Read{}});
        talk.sent();
        talk.now += 800us + 3ms; // the wire alone takes 800 µs
        talk.hear({0x55, 3, 1, 0});
        EXPECT_TRUE(talk.done());
    }
    EXPECT_EQ(talk.conversation.margin(), 6ms);
}

TEST(Conversation, MarksAnswersOfADistrustedLineForAsLongAsAnAnswerCanBeLate)
{
    for (const Duration later : {0ns, 1ns}) {
        Talk talk(framed);
        talk.conversation.distrust(talk.now);
        talk.ask(std::pair{3, fake::Read{}});
        talk.sent();
        talk.hear({0x55, 3, 1, 0});
        EXPECT_TRUE(talk.results[0].good && talk.results[0].possibly_older);
        // What came may have been an older one, and its own answer may still come as late as any.
        talk.now = talk.results[0].deadline + settings.late_max + later;
        talk.ask(std::pair{3, fake::Read{}});
        talk.sent();
        talk.hear({0x55, 3, 1, 0});
        EXPECT_EQ(talk.results[0].possibly_older, later == 0ns);
    }
}

TEST(Conversation, CountsEveryAnswerByItsRoundTripForTheLineAndForItsDevice)
{
    Talk talk(framed);
    talk.ask(std::pair{3, fake::Read{}});
    talk.sent();
    talk.now += 3ms;
    talk.hear({0x55, 3, 1, 42});
    for (const Counters& counters : {talk.conversation.counters(), talk.conversation.counters(3)}) {
        EXPECT_EQ(counters.replies, 1U);
        for (std::size_t i = 0; i < Counters::buckets; ++i)
            EXPECT_EQ(counters.round_trips[i], i == Counters::bucket_of(3ms) ? 1U : 0U) << i;
    }
}

TEST(Conversation, AResultThatWasNeverUsedSaysNothing)
{
    const Result result;
    EXPECT_FALSE(result.good);
    EXPECT_FALSE(result.possibly_older);
    EXPECT_EQ(result.tries + result.failures + result.reply_count, 0);
}

} // namespace
} // namespace sinew::bus
