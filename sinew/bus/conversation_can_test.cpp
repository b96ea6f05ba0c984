#include "sinew/bus/fake_talk.hpp"
#include "sinew/bus/fake_unusual.hpp"

#include <gtest/gtest.h>
#include <vector>

/// On CAN: what goes out when, and what is waited for.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;
using fake::Talk;

const fake::FakeProtocol framed{false};

class ConversationCan : public ::testing::Test
{
protected:
    /// What goes out now if the link takes so many frames.
    std::vector<std::uint32_t> send(std::size_t room = 64)
    {
        const auto next = talk_.conversation.next(talk_.now);
        std::vector<std::uint32_t> identifiers;
        for (const auto& frame : next.transmit)
            identifiers.push_back(frame.can_id);
        if (!identifiers.empty())
            talk_.conversation.transmitted(std::min(room, identifiers.size()), talk_.now);
        return identifiers;
    }
    void answer(unsigned id)
    {
        talk_.conversation.received({.can_id = 0x100 + id, .size = 2, .data = {5, 1}}, talk_.now);
    }

    using Identifiers = std::vector<std::uint32_t>;
    Talk talk_{framed, true};
};

TEST_F(ConversationCan, WhatTheLinkDidNotTakeIsOfferedAgain)
{
    talk_.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}}, std::pair{3, fake::CanRead{}},
              std::pair{4, fake::CanRead{}});
    EXPECT_FALSE(talk_.done()) << "it takes nothing yet";
    EXPECT_EQ(send(1), (Identifiers{0x101, 0x102, 0x103, 0x104}));
    EXPECT_EQ(send(), (Identifiers{0x102, 0x103, 0x104}));
    EXPECT_EQ(send(), Identifiers{});
}

TEST_F(ConversationCan, TheNextDeadlineIsThatOfWhatIsStillOutstanding)
{
    talk_.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}}, std::pair{3, fake::CanRead{}});
    for (std::size_t i = 0; i < 3; ++i)
        talk_.requests[i].response_time = (i + 1) * 1ms;
    ASSERT_EQ(send().size(), 3U);
    for (auto& result : talk_.results)
        result.failures = 9; // no second try
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(talk_.deadline(), talk_.results[i].deadline) << i;
        talk_.now = talk_.deadline();
        EXPECT_EQ(talk_.done(), i == 2);
        EXPECT_EQ(talk_.conversation.counters().timeouts, i + 1);
    }
}

TEST_F(ConversationCan, WhatGoesOutLaterPutsOffNoDeadline)
{
    talk_.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}}, std::pair{3, fake::CanRead{}});
    for (std::size_t i = 0; i < 3; ++i)
        talk_.requests[i].response_time = (2 * i + 1) * 1ms;
    for (std::size_t i = 0; i < 3; ++i) {
        send(1);
        EXPECT_EQ(talk_.deadline(), talk_.results[0].deadline) << i;
        talk_.now += 100us;
    }
}

TEST_F(ConversationCan, WhereNothingIsOutstandingThereIsNoDeadline)
{
    talk_.ask(std::pair{1, fake::CanRead{}});
    send();
    answer(1);
    ASSERT_TRUE(talk_.done());
    talk_.ask(std::pair{2, fake::CanRead{}});
    EXPECT_EQ(talk_.deadline(), TimePoint::max()) << "the link has not taken it yet";
}

TEST_F(ConversationCan, WhatWaitsForTheSameIdentifierGoesOutAfterTheSecondTry)
{
    talk_.ask(std::pair{1, fake::CanRead{}}, std::pair{1, fake::CanRead{}});
    EXPECT_EQ(send(), Identifiers{0x101});
    talk_.now = talk_.deadline();
    EXPECT_EQ(send(), Identifiers{0x101}) << "once more";
    EXPECT_EQ(talk_.results[0].tries, 2);
    answer(1);
    EXPECT_EQ(send(), Identifiers{0x101});
    answer(1);
    EXPECT_TRUE(talk_.done());
    EXPECT_TRUE(talk_.results[0].good && talk_.results[1].good);
}

TEST_F(ConversationCan, ARequestForAllMotorsWaitsForWhatTheLinkHasTakenAndForWhatItHasNot)
{
    talk_.ask(std::pair{1, fake::CanRead{}}, std::pair{2, fake::CanRead{}}, std::pair{0, fake::ReadAll{}});
    EXPECT_EQ(send(1), (Identifiers{0x101, 0x102}));
    EXPECT_EQ(send(), Identifiers{0x102}) << "one is outstanding and one is to go out";
}

TEST_F(ConversationCan, MoreFramesThanTheOutboxHoldsGoOutOneAfterTheOther)
{
    const auto read = *wire::make_request(1, fake::CanRead{});
    talk_.requests.assign(70, read);
    for (unsigned i = 0; i < 70; ++i)
        talk_.requests[i].frame.can_id = 0x100 + i;
    talk_.results.assign(70, {});
    talk_.conversation.begin(talk_.requests, talk_.results);
    EXPECT_EQ(send().size(), 64U);
    EXPECT_EQ(send(), (Identifiers{0x140, 0x141, 0x142, 0x143, 0x144, 0x145}));
}

TEST_F(ConversationCan, ARequestForAllMotorsThatOnlyOneAnswersIsGoodWhenItsTimeIsUp)
{
    talk_.ask(std::pair{0, fake::ReadAll{}});
    EXPECT_EQ(send(), Identifiers{0x80});
    answer(4);
    EXPECT_FALSE(talk_.done()) << "there may be more of them";
    talk_.now = talk_.deadline();
    EXPECT_TRUE(talk_.done());
    EXPECT_TRUE(talk_.results[0].good);
    EXPECT_EQ(talk_.results[0].reply_count, 1);
    EXPECT_EQ(talk_.conversation.counters().timeouts, 0U);
}

} // namespace
} // namespace sinew::bus
