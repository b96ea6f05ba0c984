#include "sinew/sim/wire/serial_wire.hpp"
#include "sinew/sim/wire/wire_test_support.hpp"
#include "tests/support/allocations.hpp"

#include <bit>
#include <deque>
#include <gtest/gtest.h>
#include <set>

namespace sinew::sim::test {
namespace {

const Bytes request{0xFF, 0xA0, 0x01, 0x02};

/// A wire at 1 Mbps, where a byte takes 10 µs, with two devices of one id; the first of them answers after 100 µs.
struct TwoDevices {
    explicit TwoDevices(Duplex duplex = Duplex::full) : wire(duplex)
    {
        second.framing = first.framing;
        first.number = second.number = request[1];
        first.answer = Answer{frame({0x12, 0x34}), 100us};
        wire.attach(first);
        wire.attach(second);
        wire.connect(&host);
    }
    void exchange(int times = 1)
    {
        for (int i = 0; i < times; ++i, now += 20ms) {
            wire.host_sends(request, rate, now);
            wire.run_until(now + 20ms);
        }
    }

    static constexpr std::uint32_t rate = 1'000'000;
    static constexpr Duration answer_starts = 140us;
    FakeStation first{rate}, second{rate};
    FakeSerialHost host{rate};
    SerialWire wire;
    TimePoint now = zero;
};

Bytes noise(std::uint64_t seed)
{
    TwoDevices bus;
    bus.wire.seed(seed);
    bus.wire.faults() = {.flip_bit = 0.1, .drop_byte = 0.05, .add_byte = 0.05};
    bus.wire.set_faults(bus.first, {.flip_bit = 0.2});
    bus.exchange(100);
    return bus.host.bytes();
}

TEST(SerialFaults, SameSeedGivesTheSameBytes)
{
    EXPECT_EQ(noise(3), noise(3));
    EXPECT_NE(noise(3), noise(4));
}

TEST(SerialFaults, FlipOneBitOfEachByteOfTheStationTheyAreSetFor)
{
    TwoDevices bus;
    bus.wire.set_faults(bus.first, {.flip_bit = 1.0});
    bus.exchange();
    ASSERT_EQ(bus.host.heard.size(), 2U);
    EXPECT_EQ(std::popcount(static_cast<unsigned>(bus.host.bytes()[0] ^ 0x12)), 1);
    EXPECT_EQ(std::popcount(static_cast<unsigned>(bus.host.bytes()[1] ^ 0x34)), 1);
    EXPECT_EQ(bus.second.heard.size(), 1U);
}

TEST(SerialFaults, StationWhoseAnswerIsLostHasAnsweredAllTheSame)
{
    TwoDevices bus;
    bus.wire.set_faults(bus.first, {.drop_byte = 1.0});
    bus.exchange();
    EXPECT_TRUE(bus.host.heard.empty());
    EXPECT_EQ(bus.first.answered_at, zero + TwoDevices::answer_starts);
}

TEST(SerialFaults, NoiseComesBehindEachByte)
{
    TwoDevices bus;
    bus.wire.set_faults(bus.first, {.add_byte = 1.0});
    bus.exchange();
    ASSERT_EQ(bus.host.heard.size(), 4U);
    EXPECT_EQ(bus.host.bytes()[0], 0x12);
    EXPECT_EQ(bus.host.bytes()[2], 0x34);
}

TEST(SerialFaults, OfTheWholeWireHitTheHostToo)
{
    TwoDevices bus;
    bus.wire.faults().drop_byte = 1.0;
    bus.exchange();
    EXPECT_TRUE(bus.first.heard.empty());
}

TEST(SerialFaults, LateReplyIsLateByWhatWasSet)
{
    TwoDevices bus;
    bus.wire.faults() = {.delay_reply = 1.0, .reply_delay = 2ms};
    bus.exchange();
    ASSERT_EQ(bus.host.heard.size(), 2U);
    EXPECT_EQ(bus.host.heard[0].second, zero + TwoDevices::answer_starts + 2ms + 10us);
}

TEST(HostEndOfASerialWire, HearsItsOwnBytesIfItHasAnEcho)
{
    for (const Duplex duplex : {Duplex::full, Duplex::half}) {
        TwoDevices bus(duplex);
        bus.wire.host_end().echo = true;
        bus.exchange();
        EXPECT_EQ(bus.host.bytes(), (Bytes{0xFF, 0xA0, 0x01, 0x02, 0x12, 0x34}));
    }
}

TEST(HostEndOfASerialWire, GetsItsBytesInBatchesFromAUsbAdapter)
{
    TwoDevices bus;
    bus.wire.host_end().usb_latency = 16ms;
    bus.exchange();
    ASSERT_EQ(bus.host.heard.size(), 2U);
    EXPECT_EQ(bus.host.heard[0].second, zero + TwoDevices::answer_starts + 10us + 16ms);
    EXPECT_EQ(bus.host.heard[1].second, zero + TwoDevices::answer_starts + 10us + 16ms);
}

TEST(HostEndOfASerialWire, DoesNotWaitOnceTheUsbPacketIsFull)
{
    TwoDevices bus;
    bus.wire.host_end().usb_latency = 16ms;
    bus.first.answer->frame.size = 24;
    for (int i = 0; i < 3; ++i)
        bus.wire.host_sends(request, TwoDevices::rate, zero);
    bus.wire.run_until(zero + 1s);
    ASSERT_EQ(bus.host.heard.size(), 72U);
    EXPECT_EQ(bus.host.heard[61].second, zero + TwoDevices::answer_starts + 620us);
    EXPECT_EQ(bus.host.heard[62].second, zero + TwoDevices::answer_starts + 630us + 16ms);
}

TEST(WrongBitRate, HostThatIsThreeTimesSlowerSamplesEveryThirdBit)
{
    // 0 0001000 0 1 as sent; in the middles of three bits each: 0 (start), 1, 0, and the idle line.
    TwoDevices bus;
    bus.first.answer = Answer{frame({0x08}), 100us};
    bus.host.rate_now = TwoDevices::rate / 3;
    bus.exchange();
    EXPECT_EQ(bus.host.bytes(), (Bytes{0xFD}));
}

TEST(WrongBitRate, HostThatIsThreeTimesFasterSeesEachBitThrice)
{
    TwoDevices bus;
    bus.host.rate_now = TwoDevices::rate * 3;
    bus.first.answer = Answer{frame({0xFF}), 100us};
    bus.exchange();
    EXPECT_EQ(bus.host.bytes(), (Bytes{0xFC}));
}

TEST(WrongBitRate, ByteWithoutItsStopBitIsPassedOnOnlyByUartsThatDo)
{
    for (const bool passes : {true, false}) {
        TwoDevices bus;
        bus.host.rate_now = TwoDevices::rate * 3;
        bus.first.answer = Answer{frame({0x00}), 100us};
        bus.wire.set_passes_broken_bytes(passes);
        bus.exchange();
        EXPECT_EQ(bus.host.bytes(), passes ? (Bytes{0x00}) : Bytes{});
    }
}

TEST(WrongBitRate, GarbageThatMakesUpARequestIsObeyed)
{
    TwoDevices bus;
    bus.second.rate_now = TwoDevices::rate / 3;
    bus.second.curious = true;
    bus.wire.refresh();
    // In the middles of three bits each: 0 (start), 1, 1, and the idle line: FF.
    for (int i = 0; i < 4; ++i) {
        bus.wire.host_sends(Bytes{0x48}, TwoDevices::rate, zero + i * 100us);
        bus.wire.run_until(zero + (i + 1) * 100us);
    }
    bus.wire.run_until(zero + 10ms);
    ASSERT_EQ(bus.second.heard.size(), 1U);
    EXPECT_EQ(bus.second.heard[0].first, frame({0xFF, 0xFF, 0xFF, 0xFF}));
    EXPECT_TRUE(bus.first.heard.empty());
}

TEST(TwoTalkers, OverlapBitByBitOnOpenDrain)
{
    // FF, and three bits later 00: the receiver has had its start bit and two ones, then all is low.
    TwoDevices bus;
    bus.first.answer = Answer{frame({0xFF}), 100us};
    bus.second.answer = Answer{frame({0x00}), 103us};
    bus.exchange();
    EXPECT_EQ(bus.host.bytes(), (Bytes{0x03}));
}

TEST(TwoTalkers, WhoSayTheSameInOneInstantAreHeardAsOneOnEveryWire)
{
    for (const Duplex duplex : {Duplex::full, Duplex::half}) {
        TwoDevices bus(duplex);
        bus.second.answer = bus.first.answer;
        bus.exchange();
        EXPECT_EQ(bus.host.bytes(), (Bytes{0x12, 0x34}));
    }
}

TEST(TwoTalkers, GarbleOnRs485WhatTheyDisagreeAboutAndNothingElse)
{
    TwoDevices bus(Duplex::half);
    bus.second.answer = Answer{frame({0x21, 0x34}), 100us};
    bus.exchange(20);
    ASSERT_EQ(bus.host.heard.size(), 40U);
    std::set<std::uint8_t> seen;
    for (std::size_t i = 0; i < 40; i += 2) {
        seen.insert(bus.host.bytes()[i]);
        EXPECT_EQ((bus.host.bytes()[i] ^ 0x12) & ~(0x12 ^ 0x21), 0);
        EXPECT_EQ(bus.host.bytes()[i + 1], 0x34);
    }
    EXPECT_GT(seen.size(), 2U);
}

TEST(TwoTalkers, ContentionCanBeSetToTheAnd)
{
    TwoDevices bus(Duplex::half);
    bus.wire.set_contention(Contention::wired_and);
    bus.second.answer = Answer{frame({0x21, 0x34}), 100us};
    bus.exchange();
    EXPECT_EQ(bus.host.bytes(), (Bytes{0x12 & 0x21, 0x34}));
}

TEST(ManyStations, AtOneRateShareOneEar)
{
    const auto scans = [](int count) {
        FourBytes framing;
        std::deque<FakeStation> stations;
        SerialWire wire{Duplex::half};
        for (int i = 0; i < count; ++i) {
            FakeStation& station = stations.emplace_back(TwoDevices::rate);
            station.framing = &framing;
            station.number = request[1] + i;
            wire.attach(station);
        }
        wire.host_sends(request, TwoDevices::rate, zero);
        wire.run_until(zero + 1s);
        EXPECT_EQ(stations.front().heard.size(), 1U);
        return framing.scans;
    };
    EXPECT_EQ(scans(200), scans(1));
}

TEST(SerialFaults, AskForNoMemory)
{
    TwoDevices bus(Duplex::half);
    bus.second.answer = Answer{frame({0x21, 0x35, 0x01}), 103us};
    bus.wire.set_faults(bus.first, {});
    bus.wire.faults() = {.flip_bit = 0.01, .drop_byte = 0.01, .add_byte = 0.01, .delay_reply = 0.1, .reply_delay = 1ms};
    bus.host.heard.reserve(1000);
    bus.first.heard.reserve(1000);
    bus.second.heard.reserve(1000);
    const auto before = support::allocations();
    bus.exchange(100);
    EXPECT_EQ(support::allocations(), before);
    EXPECT_GT(bus.host.heard.size(), 100U);
}

} // namespace
} // namespace sinew::sim::test
