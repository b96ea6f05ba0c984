#include "sinew/robot/guardian.hpp"

#include "sinew/family/sam/messages.hpp"
#include "sinew/link/links.hpp"
#include "sinew/robot/robot.hpp"

#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <functional>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <stdexcept>
#include <sys/wait.h>
#include <termios.h>
#include <thread>
#include <unistd.h>

namespace sinew::robot {
namespace {

using namespace std::chrono_literals;

constexpr int patience_ms = 20'000; // for a machine that has other work

/// A serial line: the wire is the master, what programs open is behind `link`.
struct Wire {
    link::Fd master;
    std::string uri;

    Wire()
    {
        int ends[2];
        char name[64];
        EXPECT_EQ(::openpty(&ends[0], &ends[1], name, nullptr, nullptr), 0);
        termios raw{};
        ::tcgetattr(ends[1], &raw);
        ::cfmakeraw(&raw);
        ::tcsetattr(ends[1], TCSANOW, &raw);
        ::close(ends[1]);
        master = link::Fd(ends[0]);
        uri = std::string("serial:") + name + "?baud=115200";
    }

    /// Before anybody has opened a line it reads as one that everybody has left.
    link::Fd keep_open() const { return link::Fd(::open(::ptsname(master.get()), O_RDWR | O_NOCTTY | O_CLOEXEC)); }

    /// So many bytes, or fewer where the line ends or nothing more comes.
    std::vector<std::uint8_t> read(std::size_t count, int wait_ms = patience_ms) const
    {
        std::vector<std::uint8_t> out;
        pollfd ready{.fd = master.get(), .events = POLLIN, .revents = 0};
        while (out.size() < count && ::poll(&ready, 1, wait_ms) > 0) {
            std::array<std::uint8_t, 256> some{};
            const auto got = ::read(master.get(), some.data(), std::min(some.size(), count - out.size()));
            if (got <= 0)
                break; // nobody has it open any more
            out.insert(out.end(), some.begin(), some.begin() + got);
        }
        return out;
    }
    /// All that comes before everybody has closed the line.
    std::vector<std::uint8_t> read_to_end() const { return read(100'000); }
};

wire::Request stop_of(int id)
{
    return *wire::make_request(id, sam::SpecialControl{.mode = sam::Mode::passive});
}

std::vector<std::uint8_t> times(int count, std::span<const wire::Request> requests)
{
    std::vector<std::uint8_t> out;
    for (int i = 0; i < count; ++i)
        for (const auto& request : requests)
            out.insert(out.end(), request.frame.bytes().begin(), request.frame.bytes().end());
    return out;
}

/// A program with a guardian over one line, as a process of its own; `life` is what it does.
class Program
{
public:
    struct Inside {
        Guardian& guardian;
        link::AnyLink& link;
    };

    Program(const Wire& wire, std::span<const wire::Request> stop, const std::function<void(Inside)>& life,
            Guardian::Settings settings = {})
        : Program(wire, StopFrames{.seen = stop, .unseen = stop}, life, settings)
    {
    }
    Program(const Wire& wire, const StopFrames& stop, const std::function<void(Inside)>& life,
            Guardian::Settings settings = {})
    {
        int ends[2];
        EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
        pid_ = ::fork();
        if (pid_ == 0)
            live(wire, stop, life, settings, ends[1]);
        ::close(ends[1]);
        char told = '?';
        EXPECT_EQ(::read(ends[0], &told, 1), 1);
        EXPECT_EQ(told, '+') << "it could not start";
        ::close(ends[0]);
    }
    ~Program() { end(SIGKILL); }

    int pid() const { return pid_; }
    void end(int signal)
    {
        if (pid_ <= 0)
            return;
        ::kill(pid_, signal);
        wait();
    }
    int wait()
    {
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = -1;
        return status;
    }

private:
    [[noreturn]] static void live(const Wire& wire, const StopFrames& stop, const std::function<void(Inside)>& life,
                                  Guardian::Settings settings, int told)
    {
        // A shell starts what it runs in the background with some of them ignored.
        for (const int signal : {SIGINT, SIGQUIT, SIGHUP, SIGTERM})
            std::signal(signal, SIG_DFL);
        {
            auto guardian = Guardian::start(settings);
            link::RealClock clock;
            auto link = link::Links::system().open(wire.uri, clock);
            const bool good = guardian && link && guardian->watch(0, wire.uri, *link, stop);
            if (::write(told, good ? "+" : "-", 1) != 1 || !good)
                ::_exit(1);
            life({*guardian, *link});
        }
        ::_exit(0);
    }

    int pid_ = -1;
};

void forever(Program::Inside)
{
    for (;;)
        ::pause();
}

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
            inside.guardian.update(0, inside.link, {.seen = other, .unseen = other});
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

TEST(GuardianTest, AProgramThatBeatsNoMoreIsStoppedAlthoughItLives)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop,
                    [](Program::Inside inside) {
                        inside.guardian.beat();
                        forever(inside);
                    },
                    {.patience = 50ms});
    const auto all = times(3, stop);
    EXPECT_EQ(wire.read(all.size()), all);
}

/// By then the place where a motor was to hold is old.
TEST(GuardianTest, AProgramThatHangsGetsTheFramesForMotorsThatNobodySees)
{
    const Wire wire;
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    Program program(wire, StopFrames{.seen = hold, .unseen = brake},
                    [](Program::Inside inside) {
                        inside.guardian.beat();
                        forever(inside);
                    },
                    {.patience = 150ms});
    const auto all = times(3, brake);
    EXPECT_EQ(wire.read(all.size()), all);
}

TEST(GuardianTest, AHungProgramIsStoppedFromElsewhereByTheFramesForMotorsThatNobodySees)
{
    const Wire wire;
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    Program program(wire, StopFrames{.seen = hold, .unseen = brake}, forever);
    ASSERT_TRUE(stop_program(program.pid()));
    const auto all = times(3, brake);
    EXPECT_EQ(wire.read(all.size()), all);
}

TEST(GuardianTest, AProgramThatDiesWhileItLooksGetsTheFramesForMotorsThatAreSeen)
{
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    constexpr int most_tries = 50; // a machine with other work may wake the guardian late
    std::vector<std::uint8_t> said;
    for (int i = 0; i < most_tries && said != times(3, hold); ++i) {
        const Wire wire;
        Program program(wire, StopFrames{.seen = hold, .unseen = brake}, [&](Program::Inside inside) {
            inside.guardian.update(0, inside.link, {.seen = hold, .unseen = brake});
            ::_exit(0);
        });
        said = wire.read_to_end();
        EXPECT_TRUE(said == times(3, hold) || said == times(3, brake));
    }
    EXPECT_EQ(said, times(3, hold));
}

TEST(GuardianTest, AProgramThatNeverBeatIsLeftAlone)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, forever, {.patience = 20ms});
    EXPECT_TRUE(wire.read(1, 300).empty());
}

/// Where nobody answers, a stop takes longer than a program may be without a sign of life.
TEST(GuardianTest, ALongStopIsNoProgramThatHangs)
{
    const Wire silent, guarded;
    const auto keeper = guarded.keep_open();
    auto guardian = Guardian::start({.patience = 500ms});
    ASSERT_TRUE(guardian);
    link::RealClock clock;
    const auto file =
        config::parse_robot_file("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                                 "model = \"SAM-5\"\n",
                                 "arm.toml");
    ASSERT_TRUE(file);
    OpenOptions options{.links = {{"s", silent.uri}}, .guardian = &*guardian};
    options.settings.margin_at_first = options.settings.margin_least = options.settings.margin_most = 1s;
    auto robot = Robot::open(*file, link::Links::system(), clock, options);
    ASSERT_TRUE(robot) << to_sentence(robot.error());
    const auto link = link::Links::system().open(guarded.uri, clock);
    ASSERT_TRUE(link);
    const std::array stop{stop_of(1)};
    ASSERT_TRUE(guardian->watch(1, guarded.uri, *link, {.seen = stop, .unseen = stop}));
    guardian->beat();
    const TimePoint begun = clock.now();
    EXPECT_EQ(robot->stop().at(0).outcome, Stopped::Outcome::failed);
    EXPECT_GT(clock.now() - begun, 3 * 500ms) << "too short to tell";
    EXPECT_TRUE(guarded.read(1, 0).empty()) << "the guardian took a long stop for a program that hangs";
}

TEST(GuardianTest, AStopFromElsewhereIsTheProgramsFirst)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, [](Program::Inside inside) {
        for (;;) {
            if (inside.guardian.stop_asked()) {
                inside.guardian.stop_begun();
                inside.guardian.stopped(0, StoppedBus::Outcome::failed, "not confirmed by elbow");
                inside.guardian.stop_done();
            }
            std::this_thread::yield();
        }
    });
    const auto guarded = guarded_programs();
    const auto found = std::ranges::find(guarded, program.pid(), &Guarded::pid);
    ASSERT_NE(found, guarded.end());
    EXPECT_EQ(found->links, std::vector{wire.uri});
    const auto said = stop_program(program.pid());
    ASSERT_TRUE(said);
    EXPECT_FALSE(said->by_guardian);
    ASSERT_EQ(said->buses.size(), 1U);
    EXPECT_EQ(said->buses.front().link, wire.uri);
    EXPECT_EQ(said->buses.front().outcome, StoppedBus::Outcome::failed);
    EXPECT_EQ(said->buses.front().says, "not confirmed by elbow");
    EXPECT_TRUE(wire.read(1, 100).empty());
}

TEST(GuardianTest, AProgramThatDoesNotObeyIsStoppedByItsGuardian)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, forever);
    const auto said = stop_program(program.pid());
    ASSERT_TRUE(said);
    EXPECT_TRUE(said->by_guardian);
    ASSERT_EQ(said->buses.size(), 1U);
    EXPECT_EQ(said->buses.front().outcome, StoppedBus::Outcome::sent);
    const auto all = times(3, stop);
    EXPECT_EQ(wire.read(all.size()), all);
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
        if (other && inside.guardian.watch(1, wire.uri, *other, {.seen = stop, .unseen = stop}))
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
            if (other && inside.guardian.watch(1, next.uri, *other, {.seen = stop, .unseen = stop}))
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

TEST(GuardianTest, NobodyIsFoundWhereNobodyIsWatched)
{
    const auto said = stop_program(1);
    ASSERT_FALSE(said);
    EXPECT_EQ(said.error().code, Errc::link_not_found);
}

} // namespace
} // namespace sinew::robot
