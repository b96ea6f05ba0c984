#include "sinew/bus/fake_scripted_for_tests.hpp"

#include <array>
#include <gtest/gtest.h>
#include <vector>

/// How often a bus reads a line of bytes before it waits: until there is no more.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};

class BusBytes : public ::testing::Test
{
protected:
    static std::vector<std::uint8_t> answer(std::uint8_t id) { return {0x55, id, 1, 42}; }
    /// Asks devices 3 and 4. Whether both have answered without a time-out.
    bool ask_both()
    {
        const std::array requests{*wire::make_request(3, fake::Read{}), *wire::make_request(4, fake::Read{})};
        std::array<Result, 2> results;
        EXPECT_TRUE(line_.bus.exchange(requests, results).has_value());
        return results[0].good && results[1].good && line_.bus.conversation().counters().timeouts == 0;
    }

    const TimePoint soon_ = TimePoint{1s} + 1ms;
    fake::Scripted<link::ByteLink> line_{framed};
};

TEST_F(BusBytes, AreReadOnWhileTheLinkSaysThatThereAreMore)
{
    line_.link.pieces = {{{0x55, 3}, soon_, true}, {{1, 42}, soon_}};
    line_.link.answers = {{}, answer(4)};
    EXPECT_TRUE(ask_both());
    EXPECT_EQ(line_.clock.waits, 2);
    EXPECT_EQ(line_.link.reads, 3);
}

TEST_F(BusBytes, AreReadOnWhereAsManyCameAsWereAskedFor)
{
    line_.link.pieces = {{std::vector<std::uint8_t>(256), soon_}, {answer(3), soon_}};
    line_.link.answers = {{}, answer(4)};
    EXPECT_TRUE(ask_both());
    EXPECT_EQ(line_.clock.waits, 2);
    EXPECT_EQ(line_.bus.conversation().counters().strays, 256U);
}

TEST_F(BusBytes, AreReadOnceWhereThereAreNoMore)
{
    line_.link.answers = {answer(3), answer(4)};
    EXPECT_TRUE(ask_both());
    EXPECT_EQ(line_.link.reads, 2) << "a read of nothing costs a system call";
}

TEST_F(BusBytes, BehindTheAnswerToOneRequestAreNotLeftForTheNext)
{
    line_.link.pieces = {{answer(3), soon_, true}, {{1, 2, 3}, soon_}};
    EXPECT_TRUE(line_.bus.call(3, fake::Read{}).has_value());
    EXPECT_EQ(line_.link.reads, 2);
    EXPECT_TRUE(line_.link.pieces.empty());
}

TEST_F(BusBytes, BeforeTheAnswerToOneRequestDoNotEndTheReading)
{
    line_.link.pieces = {{answer(9), soon_, true}, {answer(3), soon_}};
    EXPECT_TRUE(line_.bus.call(3, fake::Read{}).has_value());
    EXPECT_EQ(line_.link.reads, 2);
    EXPECT_EQ(line_.clock.waits, 1);
    EXPECT_EQ(line_.bus.conversation().counters().strays, 4U);
}

TEST_F(BusBytes, AreReadNoMoreWhereTheLinkIsGone)
{
    line_.link.answers = {answer(3)};
    ASSERT_TRUE(line_.bus.call(3, fake::Read{}).has_value());
    line_.link.is_gone = true;
    line_.link.reads = 0;
    EXPECT_EQ(line_.bus.tend(), TimePoint::max());
    EXPECT_EQ(line_.link.reads, 1);
    ASSERT_NE(line_.bus.link_trouble(), nullptr);
    EXPECT_EQ(line_.bus.losses(), 1U);
}

} // namespace
} // namespace sinew::bus
