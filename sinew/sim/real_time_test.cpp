#include "sinew/sim/real_time.hpp"

#include "sinew/link/links.hpp"
#include "sinew/sim/world_test_support.hpp"

#include <thread>

namespace sinew::sim::test {
namespace {

/// Counts the waits of whoever uses it.
struct CountingClock final : link::Clock {
    TimePoint now() const override { return real.now(); }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        ++waits;
        real.wait(handles, deadline);
    }
    link::RealClock real;
    int waits = 0;
};

/// Simulator and client take turns in one thread, so that each knows what the other has seen.
struct RealTimeTest : testing::Test {
    void SetUp() override
    {
        auto made = RealTimeSimulator::make(robot(), clock);
        ASSERT_TRUE(made) << to_sentence(made.error());
        simulator = std::move(*made);
    }
    link::AnyLink open(std::size_t bus)
    {
        auto link = link::Links::system().open(simulator->links()[bus].uri, clock);
        EXPECT_TRUE(link) << to_sentence(link.error());
        return std::move(*link);
    }
    void run(Duration time) { simulator->run(never, clock.now() + time); }

    /// What comes until `count` bytes are there or five seconds are over.
    Bytes read(link::ByteLink& link, std::size_t count, Duration patience = 5s)
    {
        Bytes heard;
        const TimePoint deadline = clock.now() + patience;
        while (heard.size() < count && clock.now() < deadline) {
            run(1ms);
            std::array<std::uint8_t, 64> into;
            const auto arrival = link.read(into);
            EXPECT_TRUE(arrival);
            heard.insert(heard.end(), into.begin(), into.begin() + arrival->count);
        }
        return heard;
    }
    std::vector<wire::Frame> read(link::CanLink& link, std::size_t count, Duration patience = 5s)
    {
        std::vector<wire::Frame> heard;
        const TimePoint deadline = clock.now() + patience;
        while (heard.size() < count && clock.now() < deadline) {
            run(1ms);
            std::array<wire::Frame, 8> into;
            const auto arrival = link.read(into);
            EXPECT_TRUE(arrival);
            heard.insert(heard.end(), into.begin(), into.begin() + arrival->count);
        }
        return heard;
    }

    const std::atomic<bool> never = false;
    CountingClock clock;
    std::unique_ptr<RealTimeSimulator> simulator;
};

TEST_F(RealTimeTest, TellsHowEachBusIsReached)
{
    const auto links = simulator->links();
    ASSERT_EQ(links.size(), 3U);
    EXPECT_EQ(links[0].bus, "left");
    EXPECT_EQ(links[0].family, "sam");
    EXPECT_TRUE(links[0].uri.starts_with("serial:/dev/pts/")) << links[0].uri;
    EXPECT_TRUE(links[0].uri.ends_with("?baud=1500000")) << links[0].uri;
    EXPECT_EQ(links[1].family, "nuri");
    EXPECT_TRUE(links[2].uri.starts_with("slcan:/dev/pts/")) << links[2].uri;
    EXPECT_TRUE(links[2].uri.ends_with("?bitrate=1000000")) << links[2].uri;
}

TEST_F(RealTimeTest, SerialDevicesAnswer)
{
    auto left = open(0);
    ASSERT_TRUE(bytes_of(left).write(sam_status_3));
    EXPECT_EQ(read(bytes_of(left), 2).size(), 2U);
    auto waist = open(1);
    ASSERT_TRUE(bytes_of(waist).write(nuri_ping_2));
    EXPECT_EQ(read(bytes_of(waist), 6), nuri_pong_2);
}

TEST_F(RealTimeTest, CanDevicesAnswerBehindAnSlcanAdapter)
{
    std::atomic<bool> stop = false;
    std::thread serving([&] { simulator->run(stop); }); // opening waits for the adapter's acknowledgement
    auto opened = link::Links::system().open(simulator->links()[2].uri, clock.real);
    stop = true;
    serving.join();
    ASSERT_TRUE(opened) << to_sentence(opened.error());
    const wire::Frame asked[] = {rmd_state(1), rmd_state(2)};
    ASSERT_TRUE(frames_of(*opened).write(asked));
    const auto heard = read(frames_of(*opened), 2);
    ASSERT_EQ(heard.size(), 2U);
    EXPECT_EQ(heard[0].can_id, 0x141U);
    EXPECT_EQ(heard[1].can_id, 0x142U);
    EXPECT_TRUE(read(frames_of(*opened), 1, 20ms).empty());
}

TEST_F(RealTimeTest, ASerialBusBehindATcpPortServesOneClientAfterTheOther)
{
    const RealTimeSimulator::Place places[] = {{"left", "tcp://127.0.0.1:0"}, {"waist", "tcp://localhost:0"}};
    auto made = RealTimeSimulator::make(robot(), clock, places);
    ASSERT_TRUE(made) << to_sentence(made.error());
    simulator = std::move(*made);
    const std::string uri = simulator->links()[1].uri;
    EXPECT_TRUE(uri.starts_with("tcp://127.0.0.1:")) << uri;
    EXPECT_TRUE(uri.ends_with("?baud=115200")) << uri;
    EXPECT_TRUE(simulator->links()[2].uri.starts_with("slcan:")) << "the others stay behind pseudo terminals";
    for (int visit = 0; visit < 3; ++visit) {
        auto waist = open(1);
        ASSERT_TRUE(bytes_of(waist).write(nuri_ping_1));
        EXPECT_EQ(read(bytes_of(waist), 6), nuri_pong_1) << "visit " << visit;
        auto left = open(0); // both at once
        ASSERT_TRUE(bytes_of(left).write(sam_status_3));
        EXPECT_EQ(read(bytes_of(left), 2).size(), 2U);
    }
}

TEST_F(RealTimeTest, AClientThatLeavesAmidARequestDoesNotDisturbTheNextOne)
{
    const RealTimeSimulator::Place places[] = {{"waist", "tcp://127.0.0.1:0"}};
    simulator = std::move(*RealTimeSimulator::make(robot(), clock, places));
    {
        auto waist = open(1);
        ASSERT_TRUE(bytes_of(waist).write(nuri_ping_1));
    }
    run(50ms); // the answer finds nobody
    auto waist = open(1);
    EXPECT_TRUE(read(bytes_of(waist), 1, 20ms).empty());
    ASSERT_TRUE(bytes_of(waist).write(nuri_ping_2));
    EXPECT_EQ(read(bytes_of(waist), 6), nuri_pong_2);
}

TEST_F(RealTimeTest, SaysWhichPlaceABusCannotHave)
{
    const auto refusal = [&](std::string bus, std::string uri) {
        const RealTimeSimulator::Place places[] = {{std::move(bus), std::move(uri)}};
        const auto made = RealTimeSimulator::make(robot(), clock, places);
        return made ? "made" : to_sentence(made.error());
    };
    EXPECT_EQ(
        refusal("legs", "tcp://127.0.0.1:0"),
        "bus legs cannot be simulated at tcp://127.0.0.1:0: CAN buses are reached by can:INTERFACE, or by an SLCAN "
        "adapter where no link is given");
    EXPECT_EQ(
        refusal("left", "can:vcan0"),
        "bus left cannot be simulated at can:vcan0: serial buses are reached by tcp://ADDRESS:PORT, or by a pseudo "
        "terminal where no link is given");
    EXPECT_EQ(refusal("left", "tcp://127.0.0.1:many"),
              "'tcp://127.0.0.1:many' must be written tcp://ADDRESS:PORT, such as tcp://127.0.0.1:4001");
    EXPECT_EQ(refusal("left", "tcp://example:1"), "'example' is no address to listen on, such as 127.0.0.1");
    EXPECT_NE(refusal("arm", "tcp://127.0.0.1:0").find("left, waist, legs"), std::string::npos);
}

TEST_F(RealTimeTest, ATcpPortThatIsTakenIsBusy)
{
    const RealTimeSimulator::Place anywhere[] = {{"left", "tcp://127.0.0.1:0"}};
    simulator = std::move(*RealTimeSimulator::make(robot(), clock, anywhere));
    const std::string uri = simulator->links()[0].uri;
    const RealTimeSimulator::Place taken[] = {{"left", uri.substr(0, uri.find('?'))}};
    const auto made = RealTimeSimulator::make(robot(), clock, taken);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, Errc::link_busy);
}

TEST_F(RealTimeTest, DevicesAnswerAtTheirOwnRateOnly)
{
    auto link = open(1);
    ASSERT_TRUE(bytes_of(link).set_bit_rate(9'600));
    ASSERT_TRUE(bytes_of(link).write(nuri_ping_1));
    run(50ms);
    ASSERT_TRUE(bytes_of(link).set_bit_rate(115'200));
    ASSERT_TRUE(bytes_of(link).write(nuri_ping_2));
    EXPECT_EQ(read(bytes_of(link), 6), nuri_pong_2);
}

TEST_F(RealTimeTest, ProgramsComeAndGo)
{
    for (int visit = 0; visit < 3; ++visit) {
        auto link = open(1);
        ASSERT_TRUE(bytes_of(link).write(nuri_ping_1));
        EXPECT_EQ(read(bytes_of(link), 6), nuri_pong_1);
    }
}

TEST_F(RealTimeTest, SleepsWhileNothingIsToBeDone)
{
    clock.waits = 0;
    run(10 * RealTimeSimulator::idle_step);
    EXPECT_LE(clock.waits, 12);
}

TEST_F(RealTimeTest, CountsWhatWasDoneLate)
{
    auto link = open(0);
    ASSERT_TRUE(bytes_of(link).write(sam_status_0));
    run(0ms); // takes the request in and does nothing more
    EXPECT_EQ(simulator->late(), 0U);
    clock.wait({}, clock.now() + 2 * RealTimeSimulator::late_limit);
    EXPECT_EQ(read(bytes_of(link), 2).size(), 2U);
    EXPECT_GE(simulator->late(), 1U);
}

TEST_F(RealTimeTest, StopsWhenItIsTold)
{
    const std::atomic<bool> stopped = true;
    clock.waits = 0;
    simulator->run(stopped);
    EXPECT_EQ(clock.waits, 0);
}

TEST_F(RealTimeTest, IgnoresMoreBytesThanTheWireTakesWithoutSpinning)
{
    auto link = open(1);
    ASSERT_TRUE(bytes_of(link).set_bit_rate(9'600));
    const Bytes much(1'000, 0x00);
    std::size_t sent = 0;
    for (int i = 0; i < 10; ++i) {
        sent += *bytes_of(link).write(much);
        run(1ms);
    }
    EXPECT_GT(sent, SerialWire::host_capacity);
    clock.waits = 0;
    run(100ms);
    EXPECT_LE(clock.waits, 250); // a byte takes a millisecond, and begins and ends
}

} // namespace
} // namespace sinew::sim::test
