#include "sinew/bus/conversation.hpp"
#include "sinew/bus/fake_family.hpp"

#include <gtest/gtest.h>
#include <vector>

/// What becomes of bytes on a serial line that are no answer.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

/// Frames of the fake family, and longer ones of which only the beginning `AA` ever comes.
class LongerFrames final : public wire::Protocol
{
public:
    wire::Scan find_request(std::span<const std::uint8_t> bytes, bool silent) const override
    {
        return framed_.find_request(bytes, silent);
    }
    wire::Scan find_reply(std::span<const std::uint8_t> bytes, std::size_t awaited, bool silent) const override
    {
        if (bytes.front() == 0xAA && !silent)
            return {};
        return framed_.find_reply(bytes, awaited, silent);
    }
    const wire::MessageInfo* identify(const wire::Frame&, wire::Direction, const wire::Profile&) const override
    {
        return nullptr;
    }
    int addressee(const wire::Frame& request) const override { return framed_.addressee(request); }
    bool answers(const wire::Frame& asked, const wire::MessageInfo& message, const wire::Frame& reply,
                 wire::Options options) const override
    {
        return framed_.answers(asked, message, reply, options);
    }
    std::expected<wire::Request, Error> probe(int id) const override { return framed_.probe(id); }

private:
    fake::FakeProtocol framed_{false};
};

class ConversationStray : public ::testing::Test
{
protected:
    ConversationStray()
    {
        conversation_.set_tap([this](const Tapped& tapped) {
            if (tapped.verdict != Verdict::sent)
                seen_.push_back({tapped.verdict, tapped.bytes.size()});
        });
    }
    void ask(std::initializer_list<int> ids)
    {
        for (const int id : ids)
            requests_.push_back(*wire::make_request(id, fake::Read{}));
        results_.assign(requests_.size(), {});
        conversation_.begin(requests_, results_);
        send();
    }
    void send()
    {
        ASSERT_EQ(conversation_.next(now_).transmit.size(), 1U);
        conversation_.transmitted(1, now_);
    }
    void hear(const std::vector<std::uint8_t>& bytes) { conversation_.received(bytes, now_); }
    bool done() { return conversation_.next(now_).done; }

    using Seen = std::vector<std::pair<Verdict, std::size_t>>;
    LongerFrames protocol_;
    Conversation conversation_{protocol_, {.can = false, .bit_rate = 100'000}, {}}; // a byte takes 100 µs
    std::vector<wire::Request> requests_;
    std::vector<Result> results_;
    TimePoint now_{1s};
    Seen seen_;
};

TEST_F(ConversationStray, TheOwnRequestThatComesBackIsAnEchoOfItsDevice)
{
    ask({3, 4, 5});
    now_ += 400us;
    hear({0x55, 3, 1, 0});
    EXPECT_EQ(conversation_.counters(3).echoes, 1U) << "an answer takes longer";
    now_ += 400us;
    hear({0x55, 3, 1, 7});
    send();
    now_ += 100us;
    hear({0x55, 3, 1, 0});
    EXPECT_EQ(conversation_.counters(3).echoes, 2U) << "of the request before";
    now_ += 300us;
    hear({0x55, 4, 1, 0});
    EXPECT_EQ(conversation_.counters(4).echoes, 1U);
    hear({0x55, 5, 1, 0});
    EXPECT_EQ(conversation_.counters(5).echoes, 0U) << "that has not gone out yet";
    EXPECT_EQ(conversation_.counters().echoes, 3U);
    EXPECT_EQ(conversation_.counters().strays, 4U);
    EXPECT_EQ(
        seen_,
        (Seen{{Verdict::echo, 4}, {Verdict::taken, 4}, {Verdict::echo, 4}, {Verdict::echo, 4}, {Verdict::stray, 4}}));
}

TEST_F(ConversationStray, OfTheFirstRequestThereIsNoneBefore)
{
    ask({3});
    hear({0x55, 9, 1, 0});
    EXPECT_EQ(conversation_.counters().echoes, 0U);
    EXPECT_EQ(conversation_.counters().strays, 4U);
}

TEST_F(ConversationStray, AnAnswerBehindTheBeginningOfAFrameIsFoundWhenTheLineIsSilent)
{
    ask({3});
    now_ += 800us;
    hear({0xAA, 0x55, 3, 1});
    hear({7});
    EXPECT_FALSE(done()) << "it may belong to the longer frame";
    now_ = conversation_.next(now_).deadline;
    EXPECT_TRUE(done());
    ASSERT_TRUE(results_[0].good);
    EXPECT_EQ(results_[0].replies[0].data[3], 7);
    EXPECT_EQ(conversation_.counters().timeouts, 0U);
    EXPECT_EQ(seen_, (Seen{{Verdict::stray, 1}, {Verdict::taken, 4}}));
}

TEST_F(ConversationStray, WhereNothingIsKeptNothingIsShownWhenItIsDropped)
{
    conversation_.distrust(now_);
    EXPECT_EQ(seen_, Seen{});
}

TEST_F(ConversationStray, ATimeOutShowsTheBytesThatCameInsteadOfTheAnswer)
{
    ask({3});
    hear({0x55, 3, 1});
    results_[0].failures = 9; // no second try
    now_ = conversation_.next(now_).deadline;
    EXPECT_TRUE(done());
    ASSERT_EQ(results_[0].error.code, Errc::timeout);
    ASSERT_EQ(results_[0].error.seen_size, 3U);
    EXPECT_EQ(results_[0].error.seen[1], 3);
    EXPECT_EQ(conversation_.counters().strays, 3U);
}

TEST_F(ConversationStray, BytesWithoutAnEndBehindAFirstOneAreDroppedAsWell)
{
    ask({3});
    hear({0xAA});
    hear(std::vector<std::uint8_t>(300, 0xAA));
    EXPECT_EQ(conversation_.counters().strays, 256U);
}

TEST_F(ConversationStray, BytesWithoutAnEndAreDroppedWhenNoMoreCanBeKept)
{
    ask({3});
    std::vector<std::uint8_t> noise(600, 0xAA);
    hear(noise);
    EXPECT_EQ(conversation_.counters().strays, 512U) << "twice what is kept";
    hear({0xAA});
    EXPECT_EQ(conversation_.counters().strays, 512U);
    results_[0].failures = 9; // no second try
    now_ = conversation_.next(now_).deadline;
    EXPECT_TRUE(done());
    EXPECT_FALSE(results_[0].good);
    EXPECT_EQ(conversation_.counters().strays, 601U);
}

} // namespace
} // namespace sinew::bus
