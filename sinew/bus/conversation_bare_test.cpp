#include "sinew/bus/fake_talk.hpp"

#include <gtest/gtest.h>
#include <vector>

/// Replies that carry neither header nor checksum: only their number of bytes and their time tell whose they are.
namespace sinew::bus {
namespace {

using fake::settings;
using fake::Talk;
using namespace std::chrono_literals;

const fake::FakeProtocol bare{true};

TEST(ConversationBare, QuarantinesALineOfBareRepliesUntilItIsSilentAndTheDeviceNamesItself)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.sent();
    talk.now = talk.deadline();
    const TimePoint quiet = talk.deadline();
    EXPECT_EQ(quiet - talk.now, settings.late_max) << "nothing goes out in quarantine";
    talk.now += 10ms;
    talk.hear({7, 7}); // the late answer
    EXPECT_EQ(talk.deadline(), talk.now + settings.late_max) << "the silence starts again";
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
    talk.hear({3, 3});
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BareRead{}));
    talk.hear({8, 8});
    EXPECT_TRUE(talk.done());
    EXPECT_FALSE(talk.conversation.busy());
    EXPECT_EQ(talk.results[0].reply()->data[0], 8);
    EXPECT_EQ(talk.conversation.counters().quarantines, 1U);
}

TEST(ConversationBare, CountsHalfABareAnswerAsBytesOfNobody)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.sent();
    talk.hear({7});
    talk.now = talk.deadline();
    EXPECT_FALSE(talk.sent()) << "quarantine";
    EXPECT_EQ(talk.results[0].error.seen_size, 1U);
    EXPECT_EQ(talk.conversation.counters().strays, 1U);
    EXPECT_EQ(talk.conversation.counters().timeouts, 1U);
}

TEST(ConversationBare, TakesNoBareBytesForAnAnswerThatCameBeforeTheRequest)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.sent();
    talk.conversation.received(std::vector<std::uint8_t>{7, 7}, talk.now - 1ms);
    EXPECT_FALSE(talk.done());
    EXPECT_EQ(talk.conversation.counters().strays, 2U);
}

TEST(ConversationBare, ProbesALineThatNeverFallsSilentAfterAWhile)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.sent();
    talk.now = talk.deadline();
    const TimePoint start = talk.now;
    std::optional<wire::Frame> probe;
    while (!(probe = talk.sent()) && talk.now < start + 10s) {
        talk.now += 20ms;
        talk.hear({1});
    }
    EXPECT_EQ(probe, *wire::encode_request(3, fake::BarePing{}));
    EXPECT_LE(talk.now - start, 10 * settings.late_max + 20ms);
}

TEST(ConversationBare, TrustsNoBareReplyAfterBytesThatNobodyAskedFor)
{
    Talk talk(bare);
    talk.hear({1, 2, 3});
    EXPECT_EQ(talk.conversation.counters().strays, 3U);
    talk.ask(std::pair{3, fake::BareRead{}});
    EXPECT_EQ(talk.deadline() - talk.now, settings.late_max);
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
    talk.hear({3, 3});
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BareRead{}));
    talk.hear({8, 8});
    EXPECT_EQ(talk.results[0].reply()->data[0], 8);
}

TEST(ConversationBare, WithholdsNoCommandFromADeviceWhoseAnswersDoNotComeThrough)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareSet{}}, std::pair{4, fake::BareSet{}});
    std::vector<wire::Frame> sent;
    for (int i = 0; i < 20 && !talk.done(); ++i) {
        if (const auto frame = talk.sent())
            sent.push_back(*frame);
        else
            talk.now = talk.deadline();
    }
    EXPECT_EQ(sent, (std::vector{*wire::encode_request(3, fake::BareSet{}), *wire::encode_request(4, fake::BarePing{}),
                                 *wire::encode_request(4, fake::BareSet{})}));
    EXPECT_EQ(talk.results[1].reply().error().code, Errc::timeout);
    EXPECT_FALSE(talk.conversation.busy());
}

TEST(ConversationBare, AfterACommandThatWentOutUnprovenTheNextOneIsProvenFirst)
{
    Talk talk(bare);
    talk.conversation.distrust(talk.now);
    talk.ask(std::pair{3, fake::BareSet{}}, std::pair{4, fake::BareSet{}});
    std::vector<wire::Frame> sent;
    for (int i = 0; i < 20 && !talk.done(); ++i) {
        if (const auto frame = talk.sent())
            sent.push_back(*frame);
        else
            talk.now = talk.deadline();
    }
    EXPECT_EQ(sent,
              (std::vector{*wire::encode_request(3, fake::BarePing{}), *wire::encode_request(3, fake::BareSet{}),
                           *wire::encode_request(4, fake::BarePing{}), *wire::encode_request(4, fake::BareSet{})}));
}

TEST(ConversationBare, AReadOfADeviceThatDoesNotNameItselfEndsWithItsProbe)
{
    Talk talk(bare);
    talk.conversation.distrust(talk.now);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
    talk.now = talk.deadline();
    EXPECT_TRUE(talk.done());
    EXPECT_EQ(talk.results[0].reply().error().code, Errc::timeout);
    EXPECT_EQ(talk.results[0].reply().error().message, "bare-read");
    EXPECT_EQ(talk.results[0].at, talk.now);
    EXPECT_FALSE(talk.conversation.busy());
}

TEST(ConversationBare, AProbeThatWasCutShortIsMadeUpForAfterSilence)
{
    for (const bool went_out : {false, true}) {
        Talk talk(bare);
        talk.conversation.distrust(talk.now);
        talk.ask(std::pair{3, fake::BareRead{}});
        talk.now = talk.deadline();
        if (went_out)
            EXPECT_TRUE(talk.sent());
        else
            EXPECT_FALSE(talk.done()) << "the link takes nothing";
        talk.conversation.abandon({.code = Errc::stopped}, talk.now);
        talk.ask(std::pair{3, fake::BareRead{}});
        EXPECT_EQ(talk.deadline() - talk.now, settings.late_max) << went_out;
        talk.now = talk.deadline();
        EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
    }
}

TEST(ConversationBare, ARequestThatHasNotGoneOutPutsNoLineInQuarantineWhenItIsAbandoned)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.conversation.abandon({.code = Errc::stopped}, talk.now);
    talk.ask(std::pair{3, fake::BareSet{}});
    talk.requests[0].answered = false;
    talk.sent();
    talk.conversation.abandon({.code = Errc::stopped}, talk.now);
    talk.ask(std::pair{3, fake::BareRead{}});
    EXPECT_TRUE(talk.sent());
    talk.conversation.abandon({.code = Errc::stopped}, talk.now);
    talk.ask(std::pair{3, fake::BareRead{}});
    EXPECT_FALSE(talk.sent()) << "the answer to this one is on its way";
}

TEST(ConversationBare, TakesAnAnswerInPieces)
{
    Talk talk(bare);
    for (int i = 0; i < 2; ++i) {
        talk.ask(std::pair{3, fake::BareRead{}});
        ASSERT_TRUE(talk.sent());
        talk.hear({7});
        EXPECT_FALSE(talk.done());
        talk.hear({9});
        EXPECT_TRUE(talk.done());
        ASSERT_TRUE(talk.results[0].good);
        EXPECT_EQ(talk.results[0].answer(), (wire::Frame{.size = 2, .data = {7, 9}}));
        EXPECT_FALSE(talk.conversation.busy());
    }
    EXPECT_EQ(talk.conversation.counters().strays, 0U);
}

TEST(ConversationBare, MoreThanCanBeKeptBehindTheFirstByteIsNoAnswerAndCountsToTheLastByte)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    ASSERT_TRUE(talk.sent());
    talk.hear({9});
    talk.hear(std::vector<std::uint8_t>(256, 9));
    EXPECT_FALSE(talk.done());
    EXPECT_EQ(talk.conversation.counters().quarantines, 1U);
    EXPECT_EQ(talk.conversation.counters().strays, 257U);
}

TEST(ConversationBare, AnAnswerMayNotBeOlderBecauseACommandBeforeWasToBeSilent)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareSet{}});
    talk.requests[0].answered = false;
    ASSERT_TRUE(talk.sent());
    talk.now = talk.deadline();
    ASSERT_TRUE(talk.done());
    talk.ask(std::pair{3, fake::BareSet{}});
    ASSERT_TRUE(talk.sent());
    talk.hear({7, 7});
    EXPECT_TRUE(talk.results[0].good);
    EXPECT_FALSE(talk.results[0].possibly_older);
}

TEST(ConversationBare, SendsWhatNeedsNoAnswerAtOnceEvenInQuarantine)
{
    Talk talk(bare);
    talk.hear({1});
    talk.ask(std::pair{3, fake::BareSet{}});
    talk.requests[0].answered = false;
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BareSet{}));
}

TEST(ConversationBare, DistrustsALineOfBareRepliesUntilTheDeviceNamesItself)
{
    Talk talk(bare);
    talk.conversation.distrust(talk.now);
    talk.ask(std::pair{3, fake::BareRead{}});
    EXPECT_EQ(talk.deadline() - talk.now, settings.late_max);
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
}

TEST(ConversationBare, AsksTheProbeOnlyOnceWhereItIsWhatIsAsked)
{
    Talk talk(bare);
    talk.hear({1, 2, 3});
    talk.ask(std::pair{3, fake::BarePing{}});
    talk.now = talk.deadline();
    EXPECT_EQ(talk.sent(), *wire::encode_request(3, fake::BarePing{}));
    talk.hear({3, 3});
    EXPECT_TRUE(talk.done());
    EXPECT_TRUE(talk.results[0].good);
}

TEST(ConversationBare, TakesNoAnswerOfWhichOneByteTooManyCameAhead)
{
    Talk talk(bare);
    talk.ask(std::pair{3, fake::BareRead{}});
    talk.sent();
    talk.hear({9});
    talk.hear({7, 7});
    EXPECT_FALSE(talk.done());
    EXPECT_EQ(talk.conversation.counters().strays, 3U);
}

} // namespace
} // namespace sinew::bus
