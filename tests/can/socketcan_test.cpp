#include "tests/can/can_test_support.hpp"

#include "sinew/link/links.hpp"
#include "tests/support/allocations.hpp"

#include <linux/can/error.h>

namespace sinew::link::test {
namespace {

/// Two programs on an interface of their own.
struct SocketCan : testing::Test {
    void SetUp() override
    {
        shell("ip link add dev vcan7 type vcan && ip link set vcan7 up");
        one = open({.interface = "vcan7"}, clock);
        two = open({.interface = "vcan7"}, clock);
        ASSERT_TRUE(one && two);
    }
    void TearDown() override { std::system("ip link del vcan7 2>/dev/null"); } // NOLINT(cert-env33-c)

    std::string refusal(const std::string& uri)
    {
        const auto link = Links::system().open(uri, clock);
        return link ? "opened" : std::string(to_word(link.error().code)) + ": " + to_sentence(link.error());
    }

    RealClock clock;
    std::unique_ptr<SocketCanLink> one, two;
};

TEST_F(SocketCan, FramesReachOthersAndDoNotComeBack)
{
    const wire::Frame sent[] = {frame(0x141, 0x9A), frame(0x280, 1), {.can_id = 0, .size = 0}};
    const auto taken = one->write(sent);
    ASSERT_TRUE(taken) << to_sentence(taken.error());
    EXPECT_EQ(*taken, 3u);
    const auto heard = read(*two, clock, 3);
    ASSERT_EQ(heard.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(heard[i], sent[i]);
    EXPECT_TRUE(is_silent(*one)) << "the own frames came back";
}

TEST_F(SocketCan, ABatchGoesOutInOrder)
{
    std::vector<wire::Frame> sent;
    for (std::uint8_t i = 0; i < 100; ++i)
        sent.push_back(frame(0x140u + i, i));
    std::size_t taken = 0;
    while (taken < sent.size()) {
        const auto count = one->write(std::span(sent).subspan(taken));
        ASSERT_TRUE(count);
        taken += *count;
    }
    EXPECT_EQ(read(*two, clock, 100), sent);
}

TEST_F(SocketCan, HearsStandardDataFramesOnly)
{
    PlainSocket other("vcan7");
    other.send(0x141 | CAN_EFF_FLAG);
    other.send(0x141 | CAN_RTR_FLAG);
    other.send(0x7FF);
    const auto heard = read(*one, clock, 1);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].can_id, 0x7FFu);
    EXPECT_TRUE(is_silent(*one));
}

TEST_F(SocketCan, HearsTheIdentifiersInUseOnly)
{
    auto opened = Links::system().open("can:vcan7?ids=141-160,280", clock);
    ASSERT_TRUE(opened) << to_sentence(opened.error());
    auto& filtered = dynamic_cast<SocketCanLink&>(*std::get<std::unique_ptr<CanLink>>(*opened));
    for (std::uint32_t id = 0; id < 0x400; ++id)
        ASSERT_EQ(*one->write({{frame(id)}}), 1u);
    std::vector<std::uint32_t> heard;
    for (const auto& each : read(filtered, clock, 33))
        heard.push_back(each.can_id);
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t id = 0x141; id <= 0x160; ++id)
        wanted.push_back(id);
    wanted.push_back(0x280);
    EXPECT_EQ(heard, wanted);
    EXPECT_TRUE(is_silent(filtered));
}

/// Whether three frames that are read later have the times at which they came. Two clocks are read one after the other
/// to convert: a little more than the moment of sending is right.
bool have_their_times(SocketCanLink& from, SocketCanLink& to, Clock& clock)
{
    std::array<std::pair<TimePoint, TimePoint>, 3> sent;
    for (auto& [before, after] : sent) {
        before = clock.now();
        EXPECT_TRUE(from.write({{frame(0x141)}}));
        after = clock.now();
        clock.wait({}, after + 20ms);
    }
    bool fine = true;
    for (const auto& [before, after] : sent) {
        wire::Frame heard;
        const auto arrival = to.read({&heard, 1});
        fine = fine && arrival && arrival->count == 1 && arrival->at >= before - 1ms && arrival->at <= after + 1ms;
    }
    return fine && is_silent(to);
}

/// The kernel begins to stamp a moment after the first socket has asked for it, and a guest stands still now and then.
TEST_F(SocketCan, EachFrameHasTheTimeAtWhichItCame)
{
    const TimePoint end = clock.now() + patience;
    while (!have_their_times(*two, *one, clock))
        ASSERT_LT(clock.now(), end);
}

TEST_F(SocketCan, AWallClockThatIsSetMeanwhileDoesNotThrowTheTimeOff)
{
    for (const std::int64_t jump_s : {-3600, 7200}) {
        ASSERT_TRUE(is_silent(*one));
        const TimePoint empty = clock.now();
        ASSERT_TRUE(two->write({{frame(0x141)}}));
        timespec wall{};
        clock_gettime(CLOCK_REALTIME, &wall);
        wall.tv_sec += jump_s;
        ASSERT_EQ(clock_settime(CLOCK_REALTIME, &wall), 0);
        wire::Frame heard;
        const auto arrival = one->read({&heard, 1});
        ASSERT_TRUE(arrival && arrival->count == 1);
        EXPECT_GE(arrival->at, empty - 10ms);
        EXPECT_LE(arrival->at, clock.now());
    }
}

/// Of each kind another number, so that none is counted for another.
TEST_F(SocketCan, ErrorFramesAreCountedByTheirKindAndNoReplies)
{
    PlainSocket controller("vcan7");
    const std::vector<std::pair<std::uint32_t, std::uint8_t>> errors{
        {CAN_ERR_ACK, 0},
        {CAN_ERR_PROT, 0},
        {CAN_ERR_BUSERROR, 0},
        {CAN_ERR_PROT | CAN_ERR_BUSERROR, 0},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_TX_OVERFLOW},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW},
        {CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_RX_WARNING},
        {CAN_ERR_RESTARTED, 0},
        {CAN_ERR_RESTARTED, 0},
        {CAN_ERR_RESTARTED, 0},
        {CAN_ERR_RESTARTED, 0},
    };
    std::vector<std::pair<std::uint32_t, std::uint8_t>> shown;
    one->set_error_tap([&](const wire::Frame& error, TimePoint at) {
        shown.emplace_back(error.can_id, error.data[1]);
        EXPECT_LE(at, clock.now());
    });
    for (const auto& [kind, detail] : errors)
        controller.send(CAN_ERR_FLAG | kind, {0, detail});
    controller.send(0x141);
    const auto heard = read(*one, clock, 1);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].can_id, 0x141u);
    const auto counters = one->counters();
    EXPECT_EQ(counters.error_frames, errors.size());
    EXPECT_EQ(counters.not_acknowledged, 1u);
    EXPECT_EQ(counters.bus_errors, 3u);
    EXPECT_EQ(counters.overruns, 2u);
    EXPECT_EQ(counters.restarts, 4u);
    EXPECT_EQ(counters.bus_offs, 0u);
    EXPECT_EQ(shown, errors);
}

TEST_F(SocketCan, BusOffIsToldOnceAndTheLinkLivesOn)
{
    PlainSocket controller("vcan7");
    controller.send(0x141, {1});
    controller.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF);
    controller.send(0x141, {2});
    ASSERT_EQ(read(*one, clock, 1).size(), 1u) << "what came before is not lost";
    const auto error = read_until_error(*one, clock);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, Errc::link_failed);
    EXPECT_EQ(to_sentence(*error),
              "vcan7 is bus-off: its controller saw too many errors and fell silent. Check bit rate, "
              "termination and wiring; 'ip link set vcan7 type can restart' starts it again");
    EXPECT_TRUE(one->state().open);
    EXPECT_EQ(one->counters().bus_offs, 1u);
    const auto heard = read(*one, clock, 1);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_EQ(heard[0].data[0], 2);
}

TEST_F(SocketCan, AnInterfaceThatGoesDownIsLostAtOnce)
{
    shell("ip link set vcan7 down");
    const TimePoint down = clock.now();
    const Handle handles[] = {{.fd = one->handle()}};
    clock.wait(handles, down + patience);
    EXPECT_LT(clock.now(), down + patience) << "the descriptor did not wake";
    const auto error = read_until_error(*one, clock);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, Errc::link_lost);
    EXPECT_EQ(to_sentence(*error), "vcan7 went down; 'ip link set vcan7 up' brings it up again");
    EXPECT_FALSE(one->state().open);
    EXPECT_EQ(one->handle(), -1);
    const auto written = two->write({{frame(0x141)}}); // who writes first hears of it too
    ASSERT_FALSE(written);
    EXPECT_EQ(to_sentence(written.error()), to_sentence(*error));
    shell("ip link set vcan7 up");
    EXPECT_FALSE(one->write({{frame(0x141)}})) << "a lost link stays lost";
    EXPECT_TRUE(SocketCanLink::open({.interface = "vcan7"}, clock));
}

TEST_F(SocketCan, AnInterfaceThatIsRemovedIsLostAtOnce)
{
    shell("ip link del vcan7");
    for (SocketCanLink* link : {one.get(), two.get()}) {
        const auto error =
            link == one.get() ? read_until_error(*link, clock) : std::optional{link->write({{frame(0x141)}}).error()};
        ASSERT_TRUE(error);
        EXPECT_EQ(error->code, Errc::link_lost);
        EXPECT_FALSE(link->state().open);
    }
    EXPECT_NE(to_sentence(one->read({}).error()).find("vcan7"), std::string::npos);
    EXPECT_EQ(
        to_sentence(two->write({{frame(0x141)}}).error()),
        "vcan7 is gone: its adapter was unplugged or the interface removed; plug it in again and bring it up with "
        "'ip link set vcan7 up'");
}

TEST_F(SocketCan, WhatIsWrongWithAnInterfaceIsSaidWhenItIsOpened)
{
    EXPECT_EQ(refusal("can:vcan8"),
              "link_not_found: there is no CAN interface 'vcan8', did you mean vcan0? There are vcan0, vcan7.");
    EXPECT_EQ(refusal("can:eth"), "link_not_found: there is no CAN interface 'eth'. There are vcan0, vcan7.");
    EXPECT_EQ(refusal("can:vcan7?bitrate=x"), "bad_uri: option bitrate must be a whole positive number, not 'x'");
    shell("ip link set vcan7 down");
    EXPECT_EQ(refusal("can:vcan7"), "link_failed: vcan7 is down: 'ip link set vcan7 up' brings it up");
}

TEST_F(SocketCan, TheBitRateIsWhatTheInterfaceTellsOrTheUriSays)
{
    EXPECT_EQ(one->state().bit_rate, 0u) << "vcan has none";
    const auto told = open({.interface = "vcan7", .stated_bit_rate = 1'000'000}, clock);
    EXPECT_EQ(told->state().bit_rate, 1'000'000u);
    EXPECT_EQ(told->set_bit_rate(1'000'000), 1'000'000u);
    const auto other = told->set_bit_rate(500'000);
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, Errc::unsupported);
}

TEST_F(SocketCan, AReaderThatFallsBehindLosesFramesAndCountsThem)
{
    constexpr std::size_t sent = 5'000;
    for (std::size_t i = 0; i < sent; ++i)
        ASSERT_EQ(*two->write({{frame(0x141, static_cast<std::uint8_t>(i))}}), 1u);
    const auto lost = one->counters().lost;
    EXPECT_GT(lost, 0u);
    const auto heard = read(*one, clock, sent - lost);
    EXPECT_EQ(heard.size(), sent - lost);
    EXPECT_TRUE(is_silent(*one));
    ASSERT_TRUE(two->write({{frame(0x142)}})); // and goes on as before
    EXPECT_EQ(read(*one, clock, 1).size(), 1u);
}

TEST_F(SocketCan, RefusesWhatIsNoFrameAndSendsNothingOfIt)
{
    const wire::Frame extended[] = {frame(0x141), frame(0x800)};
    EXPECT_EQ(one->write(extended).error().code, Errc::out_of_range);
    const wire::Frame long_one[] = {frame(0x141), {.can_id = 1, .size = 9}};
    EXPECT_EQ(one->write(long_one).error().code, Errc::bad_length);
    EXPECT_TRUE(is_silent(*two));
}

TEST_F(SocketCan, NothingIsAskedOfTheHeap)
{
    const wire::Frame sent[] = {frame(0x141), frame(0x142)};
    std::array<wire::Frame, 4> into;
    std::size_t heard = 0;
    const auto before = support::allocations();
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(one->write(sent));
        for (std::size_t look = 0; look < 4; ++look)
            heard += two->read(into)->count;
    }
    EXPECT_EQ(support::allocations(), before);
    EXPECT_EQ(heard, 200u);
}

} // namespace
} // namespace sinew::link::test
