#include "sinew/sim/simulator.hpp"

#include "sinew/sim/world_test_support.hpp"

#include <cmath>
#include <random>

namespace sinew::sim::test {
namespace {

struct SimulatorTest : testing::Test {
    void SetUp() override
    {
        auto made = Simulator::make(robot());
        ASSERT_TRUE(made) << to_sentence(made.error());
        simulator = std::move(*made);
    }
    link::AnyLink open(std::string_view bus)
    {
        auto link = simulator->open(bus);
        EXPECT_TRUE(link) << to_sentence(link.error());
        return std::move(*link);
    }
    TimePoint now() { return simulator->clock().now(); }
    void wait(TimePoint deadline) { simulator->clock().wait({}, deadline); }

    /// Sends, then waits and reads until `count` bytes are there or a second is over.
    Bytes ask(link::ByteLink& link, const Bytes& request, std::size_t count)
    {
        EXPECT_EQ(link.write(request), request.size());
        const TimePoint deadline = now() + 1s;
        Bytes heard;
        while (heard.size() < count && now() < deadline) {
            wait(deadline);
            std::array<std::uint8_t, 64> into;
            const auto arrival = link.read(into);
            EXPECT_TRUE(arrival);
            heard.insert(heard.end(), into.begin(), into.begin() + arrival->count);
            last_arrival = arrival->at;
        }
        return heard;
    }

    /// Reads all that is there; `at` is the arrival of the last byte.
    static link::Arrival drain(link::ByteLink& link)
    {
        link::Arrival all;
        std::array<std::uint8_t, 64> into;
        for (auto one = link.read(into); one && one->count != 0; one = link.read(into))
            all = {all.count + one->count, one->at};
        return all;
    }

    static Duration response_time(std::string_view family) { return find_family(family)->response_time.typical; }

    std::unique_ptr<Simulator> simulator;
    TimePoint last_arrival{};
};

TEST_F(SimulatorTest, AnswersASamReadAfterExactlyItsBits)
{
    auto link = open("left");
    EXPECT_EQ(ask(bytes_of(link), sam_status_0, 2).size(), 2U);
    const Duration expected = bit_time(40, 1'500'000) + response_time("sam") + bit_time(20, 1'500'000);
    EXPECT_EQ(now(), TimePoint{} + expected);
    EXPECT_EQ(last_arrival, now());
}

TEST_F(SimulatorTest, AnswersANuriPingAfterItsResponseDelayOfAHundredMicroseconds)
{
    auto link = open("waist");
    EXPECT_EQ(ask(bytes_of(link), nuri_ping_1, 6), nuri_pong_1);
    EXPECT_EQ(now(), TimePoint{} + bit_time(60, 115'200) + 100us + bit_time(60, 115'200));
    EXPECT_EQ(ask(bytes_of(link), nuri_ping_2, 6), nuri_pong_2);
}

TEST_F(SimulatorTest, AnswersOnCan)
{
    auto link = open("legs");
    const wire::Frame asked = rmd_state(2);
    EXPECT_EQ(frames_of(link).write({&asked, 1}), 1U);
    wait(TimePoint{} + 1s);
    std::array<wire::Frame, 4> into;
    const auto arrival = frames_of(link).read(into);
    ASSERT_EQ(arrival->count, 1U);
    EXPECT_EQ(into[0].can_id, 0x142U);
    EXPECT_EQ(into[0].data[0], 0x9C);
    const Duration delay = std::max(response_time("rmd"), bit_time(can_interframe_bits, 1'000'000));
    EXPECT_EQ(arrival->at, TimePoint{} + bit_time(can_frame_bits(asked), 1'000'000) + delay +
                               bit_time(can_frame_bits(into[0]), 1'000'000));
    EXPECT_EQ(now(), arrival->at);
}

// The bound of lateness: whatever happens between two ticks is exact to the nanosecond, so no tick, no other bus and no
// motion makes an answer later than its bits and the response time.
TEST_F(SimulatorTest, NoAnswerIsLaterThanItsBitsAndTheResponseTimeWheneverItIsAsked)
{
    constexpr std::uint32_t seed = 20'031;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    auto left = open("left"), waist = open("waist"), legs = open("legs");
    EXPECT_TRUE(bytes_of(left).write(Bytes{0xFF, 0x03, 0xC8, 0x4B})); // the elbow sets off
    const wire::Frame asked = rmd_state(2);
    for (int i = 0; i < 1000; ++i) {
        const TimePoint sent = now() + 10ms + std::chrono::nanoseconds{random() % 3'000'000};
        while (now() < sent) // nothing arrives any more that could end the wait, but the answer of the elbow
            wait(sent);
        ASSERT_EQ(now(), sent);
        drain(bytes_of(left));
        EXPECT_TRUE(bytes_of(left).write(sam_status_3));
        EXPECT_TRUE(bytes_of(waist).write(nuri_ping_1));
        EXPECT_TRUE(frames_of(legs).write({&asked, 1}));
        while (now() < sent + 9ms)
            wait(sent + 9ms);
        const auto of_sam = drain(bytes_of(left));
        EXPECT_EQ(of_sam.count, 2U);
        EXPECT_EQ(of_sam.at - sent, bit_time(40, 1'500'000) + response_time("sam") + bit_time(20, 1'500'000));
        const auto of_nuri = drain(bytes_of(waist));
        EXPECT_EQ(of_nuri.count, 6U);
        EXPECT_EQ(of_nuri.at - sent, bit_time(60, 115'200) + response_time("nuri") + bit_time(60, 115'200));
        std::array<wire::Frame, 4> frames;
        const auto of_rmd = frames_of(legs).read(frames);
        ASSERT_EQ(of_rmd->count, 1U);
        const Duration delay = std::max(response_time("rmd"), bit_time(can_interframe_bits, 1'000'000));
        EXPECT_EQ(of_rmd->at - sent,
                  bit_time(can_frame_bits(asked), 1'000'000) + delay + bit_time(can_frame_bits(frames[0]), 1'000'000));
    }
}

TEST_F(SimulatorTest, IsSilentAtAnotherRate)
{
    auto link = open("left");
    ASSERT_TRUE(bytes_of(link).set_bit_rate(115'200));
    EXPECT_TRUE(ask(bytes_of(link), sam_status_0, 2).empty());
    EXPECT_EQ(now(), TimePoint{} + 1s);
    ASSERT_TRUE(bytes_of(link).set_bit_rate(1'500'000));
    EXPECT_EQ(ask(bytes_of(link), sam_status_0, 2).size(), 2U);
}

TEST_F(SimulatorTest, TwoDevicesOfOneBusAnswerInTurn)
{
    auto link = open("left");
    EXPECT_EQ(ask(bytes_of(link), sam_status_0, 2).size(), 2U);
    EXPECT_EQ(ask(bytes_of(link), sam_status_3, 2).size(), 2U);
}

TEST_F(SimulatorTest, SamHearsAndTalksAtOnceAndNuriDoesNot)
{
    // Two requests with bytes between them, so that the host talks while the first answer is given.
    const auto heard_of_two = [&](std::string_view bus, const Bytes& request) {
        auto link = open(bus);
        for (const Bytes& part : {request, Bytes(100, 0x00), request})
            EXPECT_TRUE(bytes_of(link).write(part));
        std::size_t heard = 0;
        for (const TimePoint deadline = now() + 1s; now() < deadline;) {
            wait(deadline);
            std::array<std::uint8_t, 64> into;
            heard += bytes_of(link).read(into)->count;
        }
        return heard;
    };
    EXPECT_EQ(heard_of_two("left", sam_status_0), 4U);
    EXPECT_EQ(heard_of_two("waist", nuri_ping_1), 6U);
}

TEST_F(SimulatorTest, BusesShareOneTime)
{
    auto left = open("left");
    auto waist = open("waist");
    EXPECT_TRUE(bytes_of(waist).write(nuri_ping_1));
    EXPECT_EQ(ask(bytes_of(left), sam_status_0, 2).size(), 2U);
    const TimePoint after_sam = now();
    EXPECT_EQ(after_sam, TimePoint{} + bit_time(40, 1'500'000) + response_time("sam") + bit_time(20, 1'500'000));
    while (now() < TimePoint{} + 1s) {
        wait(TimePoint{} + 1s);
        std::array<std::uint8_t, 8> into;
        if (const auto arrival = bytes_of(waist).read(into); arrival->count != 0)
            last_arrival = arrival->at;
    }
    EXPECT_EQ(last_arrival, TimePoint{} + bit_time(60, 115'200) + 100us + bit_time(60, 115'200));
}

TEST_F(SimulatorTest, WaitsToTheDeadlineWhenNothingHappens)
{
    auto link = open("left");
    wait(TimePoint{} + 3min);
    EXPECT_EQ(now(), TimePoint{} + 3min);
    wait(TimePoint{} + 1min);
    EXPECT_EQ(now(), TimePoint{} + 3min);
}

TEST_F(SimulatorTest, WaitWithoutDeadlineReturnsWhenNothingWillHappen)
{
    wait(TimePoint::max());
    EXPECT_EQ(now(), TimePoint{});
}

TEST_F(SimulatorTest, WaitReturnsAtOnceWhileThereIsMoreToRead)
{
    auto link = open("waist");
    EXPECT_TRUE(bytes_of(link).write(nuri_ping_1));
    wait(TimePoint{} + 1s);
    simulator->world().advance(TimePoint{} + 500ms);
    std::array<std::uint8_t, 1> one;
    Bytes heard;
    for (int i = 0; i < 6; ++i) {
        EXPECT_EQ(bytes_of(link).read(one)->count, 1U);
        heard.push_back(one[0]);
        if (i < 5)
            wait(TimePoint{} + 1s);
        EXPECT_EQ(now(), TimePoint{} + 500ms);
    }
    EXPECT_EQ(heard, nuri_pong_1);
}

TEST_F(SimulatorTest, WhatNobodyReadsDoesNotHoldUpTheTime)
{
    auto waist = open("waist");
    auto left = open("left");
    EXPECT_TRUE(bytes_of(waist).write(nuri_ping_1));
    for (int wakes = 0; now() < TimePoint{} + 1s; ++wakes) {
        ASSERT_LE(wakes, 8);
        wait(TimePoint{} + 1s);
    }
    EXPECT_EQ(ask(bytes_of(left), sam_status_0, 2).size(), 2U);
}

TEST_F(SimulatorTest, BusIsOpenOnceAtATime)
{
    {
        auto link = open("left");
        const auto second = simulator->open("left");
        ASSERT_FALSE(second);
        EXPECT_EQ(second.error().code, Errc::link_busy);
        EXPECT_TRUE(bytes_of(link).write(sam_status_0));
    }
    wait(TimePoint{} + 1s); // the answer meets nobody
    auto link = open("left");
    EXPECT_EQ(ask(bytes_of(link), sam_status_0, 2).size(), 2U);
}

TEST_F(SimulatorTest, UnknownBusNamesTheBusesThereAre)
{
    for (const auto name : {"leftt", ""}) {
        const auto link = simulator->open(name);
        ASSERT_FALSE(link);
        EXPECT_EQ(link.error().code, Errc::link_not_found);
        EXPECT_NE(to_sentence(link.error()).find("left, waist, legs"), std::string::npos);
    }
}

TEST_F(SimulatorTest, LooksAtADeviceAsItIsNow)
{
    auto link = open("left");
    const auto before = simulator->world().look("elbow");
    ASSERT_TRUE(before);
    EXPECT_TRUE(bytes_of(link).write(Bytes{0xFF, 0x03, 0xC8, 0x4B})); // quick position control, id 3, to 200 of 254
    wait(now() + 10s);
    const auto after = simulator->world().look("elbow");
    ASSERT_TRUE(after);
    EXPECT_GT(std::abs(after->position_rad - before->position_rad), 0.1);
}

TEST_F(SimulatorTest, UnknownJointSuggestsTheNearest)
{
    const auto look = simulator->world().look("elbov");
    ASSERT_FALSE(look);
    EXPECT_EQ(look.error().code, Errc::unknown_name);
    EXPECT_NE(to_sentence(look.error()).find("elbow"), std::string::npos);
}

} // namespace
} // namespace sinew::sim::test
