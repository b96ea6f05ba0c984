#include "sinew/bus/conversation.hpp"
#include "sinew/bus/fake_family.hpp"

#include <gtest/gtest.h>

/// Where replies are bare a read can be asked for twice: its answer counts if both agree.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

class DoubleRead : public ::testing::Test
{
protected:
    template <class M>
    void ask(const M& message)
    {
        request_ = *wire::make_request(3, message);
        conversation_.begin({&request_, 1}, {&result_, 1});
    }
    /// Whether a frame goes out now, and it is this one.
    bool sends(const wire::Request& request)
    {
        const auto next = conversation_.next(now_);
        if (next.transmit.empty())
            return false;
        EXPECT_EQ(next.transmit.front(), request.frame);
        conversation_.transmitted(1, now_);
        return true;
    }
    void hear(int value)
    {
        now_ += 700us;
        const auto byte = static_cast<std::uint8_t>(value);
        conversation_.received(std::array{byte, byte}, now_);
    }
    bool done() { return conversation_.next(now_).done; }

    const fake::FakeProtocol bare_{true};
    Conversation conversation_{
        bare_, {.can = false, .bit_rate = 100'000}, {.late_max = 50ms, .read_retries = 1, .double_read = true}};
    wire::Request request_;
    Result result_;
    TimePoint now_{1s};
};

TEST_F(DoubleRead, GoesOutTwiceAndTheLaterAnswerIsTheResult)
{
    ask(fake::BareRead{});
    ASSERT_TRUE(sends(request_));
    hear(8);
    EXPECT_FALSE(done());
    ASSERT_TRUE(sends(request_));
    hear(9);
    EXPECT_TRUE(done());
    EXPECT_TRUE(result_.good);
    EXPECT_EQ(result_.reply_count, 1);
    EXPECT_EQ(result_.replies[0].data[0], 9);
    EXPECT_EQ(conversation_.counters().disagreements, 0U);
    EXPECT_EQ(conversation_.counters(3).requests, 2U);
    EXPECT_EQ(conversation_.counters(3).retries, 0U);
}

TEST_F(DoubleRead, ThatDisagreesIsAskedForOnceMore)
{
    ask(fake::BareRead{});
    for (const int value : {8, 100, 101, 100}) {
        EXPECT_FALSE(done());
        ASSERT_TRUE(sends(request_));
        hear(value);
    }
    EXPECT_TRUE(done());
    EXPECT_TRUE(result_.good);
    EXPECT_EQ(result_.replies[0].data[0], 100);
    EXPECT_EQ(conversation_.counters(3).disagreements, 1U);
    EXPECT_EQ(conversation_.counters(3).retries, 1U);
}

TEST_F(DoubleRead, ThatDisagreesAgainIsNoAnswer)
{
    ask(fake::BareRead{});
    for (const int value : {8, 100, 8, 100}) {
        ASSERT_TRUE(sends(request_));
        hear(value);
    }
    EXPECT_TRUE(done());
    EXPECT_FALSE(result_.good);
    EXPECT_EQ(result_.error.code, Errc::bad_reply);
    EXPECT_EQ(conversation_.counters(3).disagreements, 2U);
}

TEST_F(DoubleRead, OfWhichOnlyTheFirstIsAnsweredIsNoAnswer)
{
    ask(fake::BareRead{});
    ASSERT_TRUE(sends(request_));
    hear(8);
    ASSERT_TRUE(sends(request_));
    for (int i = 0; i < 20 && !done(); ++i) {
        now_ = conversation_.next(now_).deadline;
        if (!conversation_.next(now_).transmit.empty())
            conversation_.transmitted(1, now_);
    }
    ASSERT_TRUE(done());
    EXPECT_FALSE(result_.good);
    EXPECT_EQ(result_.error.code, Errc::timeout);
}

TEST_F(DoubleRead, IsNoMatterOfCommands)
{
    ask(fake::BareSet{});
    ASSERT_TRUE(sends(request_));
    hear(8);
    EXPECT_TRUE(done());
    EXPECT_TRUE(result_.good);
}

TEST_F(DoubleRead, IsNoMatterOfTheProbeThatEndsAQuarantine)
{
    conversation_.distrust(now_);
    now_ += 50ms;
    ask(fake::BareSet{});
    ASSERT_TRUE(sends(*wire::make_request(3, fake::BarePing{})));
    hear(3);
    ASSERT_TRUE(sends(request_));
    hear(8);
    EXPECT_TRUE(done());
    EXPECT_TRUE(result_.good);
}

TEST_F(DoubleRead, IsNoMatterOfAStop)
{
    const wire::Request stop = *wire::make_request(3, fake::BareRead{});
    Result stopped;
    conversation_.begin_stop({&stop, 1}, {&stopped, 1});
    ASSERT_TRUE(sends(stop));
    hear(8);
    EXPECT_TRUE(done());
    EXPECT_TRUE(stopped.good);
}

} // namespace
} // namespace sinew::bus
