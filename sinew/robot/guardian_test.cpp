#include "sinew/robot/guardian_for_tests.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

/// What a guardian does when its program has ended, and which programs may have one.
namespace sinew::robot::test {
namespace {

struct WayOut {
    const char* name;
    std::function<void(Program::Inside)> life;
    int signal = 0;
};

class GuardianWays : public testing::TestWithParam<WayOut>
{
};

TEST_P(GuardianWays, EveryWayOutThatNobodyAskedForStopsTheMotorsThreeTimes)
{
    const Wire wire;
    const std::array stop{stop_of(1), stop_of(7)};
    Program program(wire, stop, GetParam().life);
    if (GetParam().signal != 0)
        program.end(GetParam().signal);
    EXPECT_EQ(wire.read_to_end(), times(3, stop));
}

INSTANTIATE_TEST_SUITE_P(All, GuardianWays,
                         testing::Values(WayOut{"Sigkill", forever, SIGKILL}, WayOut{"Sigint", forever, SIGINT},
                                         WayOut{"Sigterm", forever, SIGTERM}, WayOut{"Sighup", forever, SIGHUP},
                                         WayOut{"Segmentation", forever, SIGSEGV},
                                         WayOut{"Abort", [](Program::Inside) { std::abort(); }},
                                         WayOut{"Exit", [](Program::Inside) { ::_exit(0); }},
                                         WayOut{"AnException",
                                                [](Program::Inside inside) {
                                                    try {
                                                        Guardian inner = std::move(inside.guardian);
                                                        throw std::runtime_error("out of here");
                                                    } catch (const std::runtime_error&) {
                                                    }
                                                }},
                                         WayOut{"WithAChildThatHasItsDescriptors",
                                                [](Program::Inside) {
                                                    if (::fork() == 0)
                                                        ::_exit(::system("exec sleep 0") == 0 ? 0 : 1);
                                                    ::_exit(0);
                                                }}),
                         [](const auto& way) { return way.param.name; });

TEST(GuardianTest, ANormalEndLeavesTheJointsAsTheyWereAsked)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, [](Program::Inside) {});
    EXPECT_EQ(program.wait(), 0);
    EXPECT_TRUE(wire.read_to_end().empty());
}

TEST(GuardianTest, TheFramesOfTheLastUpdateAreSent)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, [](Program::Inside inside) {
        for (int id = 2; id <= 9; ++id) {
            const std::array other{stop_of(id)};
            inside.guardian.update(0, inside.link, {.seen = other, .unseen = other, .seen_for = a_moment});
        }
        ::_exit(0);
    });
    const std::array last{stop_of(9)};
    EXPECT_EQ(wire.read_to_end(), times(3, last));
}

TEST(GuardianTest, ALinkThatWasForgottenIsClosedAndGetsNothing)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, [](Program::Inside inside) {
        inside.guardian.forget(0);
        ::_exit(0);
    });
    EXPECT_TRUE(wire.read_to_end().empty());
}

TEST(GuardianTest, AProgramThatDiesWhileItLooksGetsTheFramesForMotorsThatAreSeen)
{
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    constexpr int most_tries = 50; // a machine with other work may wake the guardian late
    std::vector<std::uint8_t> said;
    for (int i = 0; i < most_tries && said != times(3, hold); ++i) {
        const Wire wire;
        Program program(
            wire, StopFrames{.seen = hold, .unseen = brake, .seen_for = a_moment}, [&](Program::Inside inside) {
                inside.guardian.update(0, inside.link, {.seen = hold, .unseen = brake, .seen_for = a_moment});
                ::_exit(0);
            });
        said = wire.read_to_end();
        EXPECT_TRUE(said == times(3, hold) || said == times(3, brake));
    }
    EXPECT_EQ(said, times(3, hold));
}

TEST(GuardianTest, FramesWhosePlacesWereOldWhenTheyWereWrittenAreNotSent)
{
    const Wire wire;
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    const StopFrames old{.seen = hold, .unseen = brake, .seen_for = -std::chrono::milliseconds(1)};
    Program program(wire, old, [](Program::Inside) { ::_exit(0); });
    EXPECT_EQ(wire.read_to_end(), times(3, brake));
}

TEST(GuardianTest, MotorsThatHaveStoppedAreLeftAlone)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, [](Program::Inside inside) {
        inside.guardian.update(0, inside.link, {});
        ::_exit(0);
    });
    EXPECT_TRUE(wire.read_to_end().empty());
}

TEST(GuardianTest, OneLineThatTakesNothingDoesNotHoldUpTheOthers)
{
    const Wire stuck, wire;
    const std::array stop{stop_of(1)};
    const auto keeper = wire.keep_open();
    Program program(stuck, stop, [&](Program::Inside inside) {
        const int fd = std::get<std::unique_ptr<link::ByteLink>>(inside.link)->handle();
        while (::write(fd, "stuffed", 7) > 0)
            ;
        link::RealClock clock;
        const auto other = link::Links::system().open(wire.uri, clock);
        if (other && inside.guardian.watch(1, wire.uri, *other, {.seen = stop, .unseen = stop, .seen_for = a_moment}))
            ::_exit(0);
    });
    const auto all = times(3, stop);
    EXPECT_EQ(wire.read(all.size()), all);
}

/// How much such a line takes from a program before somebody reads.

std::size_t room_of_a_line()
{
    const Wire wire;
    const auto fd = wire.keep_open();
    ::fcntl(fd.get(), F_SETFL, O_NONBLOCK);
    std::size_t room = 0;
    while (::write(fd.get(), "x", 1) == 1)
        ++room;
    return room;
}

TEST(GuardianTest, AFrameOfWhichTheLineTakesAPartIsFinishedBeforeTheNext)
{
    const std::array stop{stop_of(1), stop_of(7)};
    const std::size_t stuffing = room_of_a_line() - 2;
    ASSERT_GT(stop.front().frame.size, 2);
    std::vector<std::uint8_t> expected(stuffing, 'x'), read;
    std::ranges::copy(times(3, stop), std::back_inserter(expected));
    constexpr int most_tries = 50; // where this reads too late the guardian gives the line up
    for (int i = 0; i < most_tries && read != expected; ++i) {
        const Wire wire, next;
        const auto keeper = next.keep_open();
        Program program(wire, stop, [&](Program::Inside inside) {
            const int fd = std::get<std::unique_ptr<link::ByteLink>>(inside.link)->handle();
            for (std::size_t n = 0; n < stuffing; ++n)
                if (::write(fd, "x", 1) != 1)
                    ::_exit(1);
            link::RealClock clock;
            const auto other = link::Links::system().open(next.uri, clock);
            if (other &&
                inside.guardian.watch(1, next.uri, *other, {.seen = stop, .unseen = stop, .seen_for = a_moment}))
                ::_exit(0);
        });
        next.read(1); // its turn comes after that of the line that is full
        read = wire.read_to_end();
    }
    EXPECT_EQ(read.size(), expected.size());
    EXPECT_TRUE(read == expected);
}

TEST(GuardianTest, AGuardianThatWasKilledIsMissed)
{
    auto guardian = Guardian::start();
    ASSERT_TRUE(guardian);
    EXPECT_TRUE(guardian->is_alive());
    ::kill(guardian->process_id(), SIGKILL);
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
    while (guardian->is_alive() && std::chrono::steady_clock::now() < until)
        std::this_thread::yield();
    EXPECT_FALSE(guardian->is_alive());
}

TEST(GuardianTest, AProgramWithThreadsIsRefusedWithASentence)
{
    std::atomic<bool> end = false;
    std::thread other([&] { end.wait(false); });
    const auto guardian = Guardian::start();
    ASSERT_FALSE(guardian);
    EXPECT_EQ(guardian.error().code, Errc::unsupported);
    EXPECT_NE(to_sentence(guardian.error()).find("before the program has threads"), std::string::npos);
    end = true;
    end.notify_all();
    other.join();
}

} // namespace
} // namespace sinew::robot::test
