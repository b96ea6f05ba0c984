#include "sinew/sim/wire/can_wire.hpp"

#include "sinew/sim/wire/wire_test_support.hpp"
#include "tests/support/allocations.hpp"

#include <gtest/gtest.h>

namespace sinew::sim::test {
namespace {

TEST(CanFrameBits, CountsTheStuffBitsOfAFrameOfZerosByHand)
{
    // 34 zeros up to the CRC, and its CRC is zero: a stuff bit after each five of them, six in all.
    EXPECT_EQ(can_frame_bits(frame({}, 0x000)), 44 + 6);
}

TEST(CanFrameBits, AgreesWithAnIndependentCount)
{
    // Counted over the text of the bits, with the CRC by long division.
    EXPECT_EQ(can_frame_bits(frame({0x01}, 0x014)), 55);
    EXPECT_EQ(can_frame_bits(frame({0x3C, 0x3C}, 0x078)), 63);
    EXPECT_EQ(can_frame_bits(frame({0x9C, 0, 0, 0, 0, 0, 0, 0}, 0x141)), 121);
    EXPECT_EQ(can_frame_bits(frame({0xA2, 0, 0, 0, 0x10, 0x27, 0, 0}, 0x141)), 118);
    EXPECT_EQ(can_frame_bits(frame({0x64, 0, 0x64, 0, 0x64, 0, 0x64, 0}, 0x280)), 118);
    EXPECT_EQ(can_frame_bits(frame({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, 0x7FF)), 123);
    EXPECT_EQ(can_frame_bits(frame({0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55}, 0x555)), 109);
}

TEST(CanFrameBits, StaysWithinWhatStuffingCanAdd)
{
    // 98 stuffed bits take (98 - 1) / 4 = 24 more at most.
    for (std::uint32_t id = 0; id < 0x800; ++id) {
        const int bits = can_frame_bits(frame({0x0F, 0x87, 0xC3, 0xE1, 0xF0, 0x78, 0x3C, 0x1E}, id));
        EXPECT_GE(bits, 108);
        EXPECT_LE(bits, 132);
    }
}

/// A bus at 1 Mbps, where a bit is a microsecond.
struct CanWireTest : testing::Test {
    CanWireTest()
    {
        first.curious = true;
        wire.attach(first);
        wire.attach(second);
        wire.connect(&host);
    }

    static constexpr std::uint32_t rate = 1'000'000;
    FakeStation first{rate}, second{rate};
    FakeCanHost host{rate};
    CanWire wire;
    const wire::Frame asked = frame({0x9C, 0, 0, 0, 0, 0, 0, 0}, 0x141);                     // 121 bits
    const wire::Frame answered = frame({0xA2, 0, 0, 0, 0x10, 0x27, 0, 0}, 0x141);            // 118 bits
    const wire::Frame high = frame({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}, 0x7FF); // 123 bits
};

TEST_F(CanWireTest, FramesTakeTheTimeOfTheirBits)
{
    first.answer = Answer{answered, 50us};
    ASSERT_TRUE(wire.host_sends(asked, rate, zero + 7us));
    wire.run_until(zero + 1s);
    ASSERT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(first.heard[0].second, zero + 128us);
    EXPECT_EQ(first.answered_at, zero + 128us + 50us + 118us);
    ASSERT_EQ(host.heard.size(), 1U);
    EXPECT_EQ(host.heard[0].first, answered);
    EXPECT_EQ(host.heard[0].second, zero + 128us + 50us + 118us);
    EXPECT_EQ(wire.next_event(), TimePoint::max());
}

TEST_F(CanWireTest, NextFrameStartsAfterThreeBits)
{
    wire.host_sends(asked, rate, zero);
    wire.host_sends(high, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(first.heard.size(), 2U);
    EXPECT_EQ(first.heard[1].second, zero + 121us + 3us + 123us);
}

TEST_F(CanWireTest, LowestIdentifierGoesFirstWhenTheBusFallsIdle)
{
    first.answer = Answer{high, 0ns};
    second.answer = Answer{answered, 0ns};
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(host.heard.size(), 2U);
    EXPECT_EQ(host.heard[0].first, answered);
    EXPECT_EQ(host.heard[0].second, zero + 124us + 118us);
    EXPECT_EQ(host.heard[1].first, high);
}

TEST_F(CanWireTest, FrameThatIsReadyDuringAnotherWaitsForItsEnd)
{
    wire.host_sends(high, rate, zero);
    wire.run_until(zero + 10us);
    wire.host_sends(asked, rate, zero + 10us);
    wire.run_until(zero + 1s);
    ASSERT_EQ(first.heard.size(), 2U);
    EXPECT_EQ(first.heard[0].first, high);
    EXPECT_EQ(first.heard[1].second, zero + 126us + 121us);
}

TEST_F(CanWireTest, DeviceAtAnotherRateHearsNothing)
{
    first.answer = Answer{answered, 0ns};
    first.rate_now = 500'000;
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    EXPECT_TRUE(first.heard.empty());
    EXPECT_EQ(second.heard.size(), 1U);
    EXPECT_TRUE(host.heard.empty());
}

TEST_F(CanWireTest, MessageThatChangesTheRateIsAnsweredAtTheOldOne)
{
    first.answer = Answer{answered, 0ns};
    first.next_rate = 500'000;
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.heard.size(), 1U);
}

TEST_F(CanWireTest, RequestReachesWhomItIsFor)
{
    first.curious = false;
    first.number = 3;
    wire.refresh();
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    EXPECT_TRUE(first.heard.empty());
    EXPECT_EQ(second.heard.size(), 1U);
}

TEST_F(CanWireTest, EqualAnswersInOneInstantAreHeardAsOne)
{
    first.answer = second.answer = Answer{answered, 50us};
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(host.heard.size(), 1U);
    EXPECT_EQ(host.heard[0].second, zero + 121us + 50us + 118us);
    EXPECT_EQ(first.answered_at, second.answered_at);
}

TEST_F(CanWireTest, AnswersThatDifferUnderOneIdentifierFightUntilTheyAreGivenUp)
{
    first.answer = Answer{answered, 50us};
    second.answer = Answer{frame({0x22, 0, 0, 0, 0x10, 0x27, 0, 0}, 0x141), 50us};
    wire.host_sends(asked, rate, zero);
    // 20 bits up to the first of the data, one of them stuffed; 20 of error frame and 3 of space follow.
    wire.run_until(zero + 1s);
    EXPECT_TRUE(host.heard.empty());
    EXPECT_EQ(wire.counters().error_frames, 32U);
    EXPECT_EQ(wire.counters().given_up, 2U);
    EXPECT_EQ(first.answered_at, zero + 171us + 31 * (21us + 23us) + 41us);
    EXPECT_EQ(wire.next_event(), TimePoint::max());
}

TEST_F(CanWireTest, FramesDestroyedByABitErrorAreSentAgain)
{
    wire.faults().flip_bit = 0.5;
    wire.seed(7);
    for (int i = 0; i < 50; ++i)
        wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.size(), 50U);
    EXPECT_GT(wire.counters().error_frames, 20U);
    EXPECT_EQ(wire.counters().given_up, 0U);
}

TEST_F(CanWireTest, FrameThatIsNeverRightIsGivenUp)
{
    wire.faults().flip_bit = 1.0;
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    EXPECT_TRUE(first.heard.empty());
    EXPECT_EQ(wire.counters().error_frames, 32U);
    EXPECT_EQ(wire.counters().given_up, 1U);
}

TEST_F(CanWireTest, DroppedAnswersOfOneStationAreNotHeardAndThoseOfOthersAre)
{
    first.answer = Answer{answered, 0ns};
    second.answer = Answer{high, 0ns};
    wire.set_faults(first, {.drop_byte = 1.0});
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(host.heard.size(), 1U);
    EXPECT_EQ(host.heard[0].first, high);
    EXPECT_EQ(first.answered_at, zero + 124us + 118us);
}

TEST_F(CanWireTest, AddedFrameIsTheSameOnceMore)
{
    first.answer = Answer{answered, 0ns};
    wire.set_faults(first, {.add_byte = 1.0});
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(host.heard.size(), 2U);
    EXPECT_EQ(host.heard[1].first, answered);
    EXPECT_EQ(host.heard[1].second, zero + 124us + 118us + 3us + 118us);
}

TEST_F(CanWireTest, LateReplyIsLateByWhatWasSet)
{
    first.answer = Answer{answered, 50us};
    wire.faults() = {.delay_reply = 1.0, .reply_delay = 2ms};
    wire.host_sends(asked, rate, zero);
    wire.run_until(zero + 1s);
    ASSERT_EQ(host.heard.size(), 1U);
    EXPECT_EQ(host.heard[0].second, zero + 121us + 50us + 2ms + 118us);
}

TEST_F(CanWireTest, AllocatesNothingOnceItIsBuilt)
{
    first.answer = Answer{answered, 50us};
    second.answer = Answer{high, 50us};
    const auto before = support::allocations();
    for (int i = 0; i < 20; ++i) {
        wire.host_sends(asked, rate, zero + i * 1ms);
        wire.run_until(zero + (i + 1) * 1ms);
    }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_EQ(host.heard.size(), 40U);
}

TEST_F(CanWireTest, RefusesFramesBeyondItsQueue)
{
    for (std::size_t i = 0; i < CanWire::host_capacity; ++i)
        ASSERT_TRUE(wire.host_sends(asked, rate, zero));
    EXPECT_FALSE(wire.host_sends(asked, rate, zero));
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.size(), CanWire::host_capacity);
}

} // namespace
} // namespace sinew::sim::test
