#include "sinew/sim/wire/serial_wire.hpp"
#include "tests/support/allocations.hpp"

#include "sinew/sim/wire/wire_test_support.hpp"

#include <gtest/gtest.h>

namespace sinew::sim::test {
namespace {

const Bytes request{0xFF, 0xA0, 0x01, 0x02};

/// A wire with devices at 1.5 Mbps, the first of which answers.
struct SerialWireTest : testing::Test {
    void build(Duplex duplex, std::uint32_t rate = 1'500'000)
    {
        wire = SerialWire{duplex};
        wire.attach(first);
        wire.attach(second);
        wire.connect(&host);
        for (std::uint32_t* r : {&first.rate_now, &second.rate_now, &host.rate_now})
            *r = rate;
        first.number = second.number = request[1];
        wire.refresh();
        first.answer = Answer{frame({0x12, 0x34}), 100us};
    }
    void send(const Bytes& bytes, Duration at = 0ns)
    {
        wire.run_until(zero + at);
        EXPECT_EQ(wire.host_sends(bytes, host.rate_now, zero + at), bytes.size());
    }

    FakeStation first{0}, second{0};
    FakeSerialHost host{0};
    SerialWire wire{Duplex::full};
};

TEST_F(SerialWireTest, AnswersAfterTheBitsOfTheRequestTheDelayAndTheBitsOfTheAnswer)
{
    build(Duplex::full);
    send(request);
    wire.run_until(zero + 1s);
    // 40 bits at 1.5 Mbps are 26.667 µs; each byte of the answer adds 10 bits.
    ASSERT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(first.heard[0].second, zero + 26'667ns);
    EXPECT_EQ(first.answered_at, zero + 26'667ns + 100us + 13'334ns);
    ASSERT_EQ(host.bytes(), (Bytes{0x12, 0x34}));
    EXPECT_EQ(host.heard[0].second, zero + 26'667ns + 100us + 6'667ns);
    EXPECT_EQ(host.heard[1].second, zero + 26'667ns + 100us + 13'334ns);
    EXPECT_EQ(wire.next_event(), TimePoint::max());
}

TEST_F(SerialWireTest, DoesNothingBeforeItsTime)
{
    build(Duplex::full);
    EXPECT_EQ(wire.next_event(), TimePoint::max());
    send(request);
    wire.run_until(zero + 26'666ns);
    EXPECT_TRUE(first.heard.empty());
    wire.run_until(zero + 26'667ns);
    EXPECT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(wire.next_event(), zero + 126'667ns);
}

TEST_F(SerialWireTest, DeviceAtAnotherRateHearsNothing)
{
    build(Duplex::full);
    first.rate_now = 115'200;
    wire.refresh();
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_TRUE(first.heard.empty());
    EXPECT_EQ(second.heard.size(), 1U);
    EXPECT_TRUE(host.heard.empty());
}

TEST_F(SerialWireTest, HostThatSwitchedItsRateDoesNotHearTheAnswer)
{
    build(Duplex::full);
    send(request);
    wire.run_until(zero + 50us);
    host.rate_now = 9'600;
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.size(), 1U);
    EXPECT_TRUE(host.heard.empty());
}

TEST_F(SerialWireTest, MessageThatChangesTheRateIsAnsweredAtTheOldOne)
{
    build(Duplex::full);
    first.next_rate = 9'600;
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.rate_now, 9'600U);
    ASSERT_EQ(host.bytes(), (Bytes{0x12, 0x34}));
    EXPECT_EQ(host.heard[1].second, zero + 26'667ns + 100us + 13'334ns);
}

TEST_F(SerialWireTest, DeviceThatSwitchesItsRateAfterItsAnswerHearsTheNextRequestAtTheNewOne)
{
    build(Duplex::full);
    first.later_rate = 9'600;
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12, 0x34}));
    host.rate_now = 9'600;
    send(request, 2s);
    wire.run_until(zero + 3s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12, 0x34, 0x12, 0x34}));
}

TEST_F(SerialWireTest, HearsOnThroughMoreGarbageThanItCanKeep)
{
    build(Duplex::full);
    first.own_framing.patient = true;
    send(Bytes(Receiver::capacity + 10, 0x00));
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12, 0x34}));
}

TEST_F(SerialWireTest, BytesWrittenWhileOthersAreOnTheirWayFollowWithoutAGap)
{
    build(Duplex::full, 9'600);
    send({0xFF, 0xA0});
    send({0x01, 0x02}, 1ms);
    wire.run_until(zero + 1s);
    ASSERT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(first.heard[0].second, zero + bit_time(40, 9'600));
}

TEST_F(SerialWireTest, ManyBytesInARowKeepToTheBitGrid)
{
    build(Duplex::full);
    for (int i = 0; i < 250; ++i)
        send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.back().second, zero + bit_time(10'000, 1'500'000));
}

TEST_F(SerialWireTest, TakesWhatFitsAndSaysHowMuchThatWas)
{
    build(Duplex::full);
    const Bytes much(SerialWire::host_capacity + 1, 0x00);
    EXPECT_EQ(wire.host_sends(much, 1'500'000, zero), SerialWire::host_capacity);
    EXPECT_EQ(wire.host_room(), 0U);
}

TEST_F(SerialWireTest, NothingGoesOutAtRateZero)
{
    build(Duplex::full);
    EXPECT_EQ(wire.host_sends(request, 0, zero), request.size());
    EXPECT_EQ(wire.next_event(), TimePoint::max());
}

TEST_F(SerialWireTest, PauseInsideAFrameAsUsbAdaptersMakeItDoesNotBreakIt)
{
    build(Duplex::full);
    send({0xFF, 0xA0});
    send({0x01, 0x02}, 4ms);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12, 0x34}));
}

TEST_F(SerialWireTest, FrameThatStopsIsGivenUpAfterTheSilence)
{
    build(Duplex::full);
    send({0xFF, 0xA0});
    wire.run_until(zero + 1ms);
    EXPECT_EQ(wire.next_event(), zero + 13'334ns + 5ms);
    send(request, 6ms);
    wire.run_until(zero + 1s);
    ASSERT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(first.heard[0].first, frame({0xFF, 0xA0, 0x01, 0x02}));
}

TEST_F(SerialWireTest, SilenceLastsTwentyBytesWhereBytesAreSlow)
{
    build(Duplex::full, 9'600);
    send({0xFF});
    wire.run_until(zero + 2ms);
    EXPECT_EQ(wire.next_event(), zero + bit_time(10, 9'600) + bit_time(200, 9'600));
}

TEST_F(SerialWireTest, DevicesOnFullDuplexHearTheHostAlone)
{
    build(Duplex::full);
    first.answer = Answer{frame({0xFF, 1, 2, 3}), 0ns};
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.heard.size(), 4U);
    EXPECT_EQ(second.heard.size(), 1U);
}

TEST_F(SerialWireTest, DevicesOnHalfDuplexHearEachOtherButNotThemselves)
{
    build(Duplex::half);
    first.curious = second.curious = true;
    wire.refresh();
    first.answer = Answer{frame({0xFF, 1, 2, 3}), 0ns};
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0xFF, 1, 2, 3}));
    EXPECT_EQ(first.heard.size(), 1U);
    ASSERT_EQ(second.heard.size(), 2U);
    EXPECT_EQ(second.heard[1].first, frame({0xFF, 1, 2, 3}));
}

TEST_F(SerialWireTest, TwoAnswersInOneInstantReachTheHostAsTheirAnd)
{
    build(Duplex::full);
    second.answer = Answer{frame({0x21, 0x34}), 100us};
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12 & 0x21, 0x34}));
}

TEST_F(SerialWireTest, HostOnHalfDuplexHearsNothingWhileItTalks)
{
    build(Duplex::half);
    first.answer = Answer{frame({0x12, 0x34}), 0ns};
    send(request);
    send({0x00}, 20us); // right behind the request, where the first byte of the answer stands
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x34}));
}

TEST_F(SerialWireTest, SecondRequestIsAnsweredAfterTheFirst)
{
    build(Duplex::full);
    send(request);
    send(request);
    wire.run_until(zero + 1s);
    EXPECT_EQ(host.bytes(), (Bytes{0x12, 0x34, 0x12, 0x34}));
}

TEST_F(SerialWireTest, RequestReachesWhomItIsForAndWhoHearsAll)
{
    build(Duplex::full);
    second.number = 3;
    first.framing = second.framing; // one ear
    wire.refresh();
    send(request);
    wire.run_until(zero + 1ms);
    EXPECT_EQ(first.heard.size(), 1U);
    EXPECT_TRUE(second.heard.empty());
    second.curious = true;
    wire.refresh();
    send(request, 2ms);
    wire.run_until(zero + 1s);
    EXPECT_EQ(second.heard.size(), 1U);
}

TEST_F(SerialWireTest, RequestToAllReachesEveryIdOnce)
{
    build(Duplex::full);
    second.number = 3;
    second.curious = true;
    wire.refresh();
    send({0xFF, 0x55, 0x01, 0x02});
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.size(), 1U);
    EXPECT_EQ(second.heard.size(), 1U);
}

TEST_F(SerialWireTest, DeviceThatTakesAnotherIdIsFoundThereAtOnce)
{
    build(Duplex::full);
    first.next_number = 7;
    send(request);
    send({0xFF, 0x07, 0x00, 0x00});
    wire.run_until(zero + 1s);
    EXPECT_EQ(first.heard.size(), 2U);
}

TEST_F(SerialWireTest, AllocatesNothingOnceItIsBuilt)
{
    build(Duplex::half);
    const auto before = support::allocations();
    TimePoint now = zero;
    for (int i = 0; i < 20; ++i) {
        wire.host_sends(request, 1'500'000, now);
        now += 1ms;
        wire.run_until(now);
    }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_EQ(host.heard.size(), 40U);
}

} // namespace
} // namespace sinew::sim::test
