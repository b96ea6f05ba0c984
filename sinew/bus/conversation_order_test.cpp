#include "sinew/bus/conversation.hpp"
#include "sinew/bus/fake_unusual.hpp"

#include <gtest/gtest.h>
#include <vector>

/// What goes out again, and what goes out together.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};

/// How often a request goes out that nobody answers.
template <class M>
int tries(const M& message, Settings settings)
{
    Conversation conversation(framed, {.can = false, .bit_rate = 100'000}, settings);
    const auto request = *wire::make_request(3, message);
    Result result;
    conversation.begin({&request, 1}, {&result, 1});
    TimePoint now{1s};
    for (int count = 0;; ++count) {
        const auto next = conversation.next(now);
        if (next.done)
            return count;
        EXPECT_FALSE(next.transmit.empty());
        conversation.transmitted(1, now);
        now = conversation.next(now).deadline;
    }
}

TEST(ConversationOrder, WhatIsNotAnsweredGoesOutAgainAsOftenAsItMay)
{
    EXPECT_EQ(tries(fake::Read{}, {.read_retries = 0}), 1);
    EXPECT_EQ(tries(fake::Read{}, {.read_retries = 2}), 3);
    EXPECT_EQ(tries(fake::Set{}, {.read_retries = 2}), 1);
    EXPECT_EQ(tries(fake::Set{}, {.read_retries = 0, .command_retries = 1}), 2);
    EXPECT_EQ(tries(fake::Set{}, {.read_retries = 0, .command_retries = 2}), 3);
}

TEST(ConversationOrder, ARelativeMoveAndWhatWritesFlashGoOutOnce)
{
    EXPECT_EQ(tries(fake::Push{}, {.command_retries = 3}), 1);
    EXPECT_EQ(tries(fake::Store{}, {.command_retries = 3}), 1);
}

TEST(ConversationOrder, OnCanARequestForAllMotorsGoesOutAlone)
{
    Conversation conversation(framed, {.can = true, .bit_rate = 1'000'000}, {.read_retries = 0});
    const std::vector requests{*wire::make_request(1, fake::CanRead{}), *wire::make_request(2, fake::CanRead{}),
                               *wire::make_request(0, fake::ReadAll{}), *wire::make_request(3, fake::CanRead{})};
    std::vector<Result> results(requests.size());
    TimePoint now{1s};
    const auto send = [&] {
        const auto next = conversation.next(now);
        std::vector<std::uint32_t> identifiers;
        for (const auto& frame : next.transmit)
            identifiers.push_back(frame.can_id);
        conversation.transmitted(identifiers.size(), now);
        return identifiers;
    };
    const auto answer = [&](unsigned id) {
        conversation.received(wire::Frame{.can_id = 0x100 + id, .size = 2, .data = {5, 1}}, now);
    };
    using Identifiers = std::vector<std::uint32_t>;
    conversation.begin(requests, results);
    EXPECT_EQ(send(), (Identifiers{0x101, 0x102}));
    answer(1);
    EXPECT_EQ(send(), Identifiers{}) << "motor 2 has not answered yet";
    answer(2);
    EXPECT_EQ(send(), Identifiers{0x80});
    EXPECT_EQ(send(), Identifiers{}) << "motor 3 would be asked while it answers";
    now = conversation.next(now).deadline;
    EXPECT_EQ(send(), Identifiers{0x103});
    answer(3);
    EXPECT_TRUE(conversation.next(now).done);
    EXPECT_TRUE(results[3].good);
}

} // namespace
} // namespace sinew::bus
