#include "sinew/robot/guardian_for_tests.hpp"
#include "sinew/robot/robot.hpp"

#include <algorithm>
#include <thread>

/// What a guardian does while its program lives: when that hangs, and when somebody else asks for a stop.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

void hang(Program::Inside inside)
{
    inside.guardian.beat();
    forever(inside);
}

TEST(GuardianTest, AProgramThatBeatsNoMoreIsStoppedAlthoughItLives)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, hang, {.patience = 50ms});
    const auto all = times(3, stop);
    EXPECT_EQ(wire.read(all.size()), all);
}

TEST(GuardianTest, AProgramThatHangsGetsTheFramesForMotorsThatNobodySees)
{
    const Wire wire;
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    Program program(wire, StopFrames{.seen = hold, .unseen = brake, .seen_for = a_moment}, hang, {.patience = 150ms});
    const auto all = times(3, brake);
    EXPECT_EQ(wire.read(all.size()), all);
}

/// A slow one, not a hung one.
TEST(GuardianTest, AProgramThatWritesOtherFramesDuringAStopTakesNoneOfItAway)
{
    const Wire wire;
    std::vector<wire::Request> long_stop;
    for (int id = 1; id <= 30; ++id)
        long_stop.push_back(stop_of(id));
    const std::array short_stop{stop_of(1)};
    Program program(wire, StopFrames{.seen = long_stop, .unseen = long_stop, .seen_for = a_moment},
                    [&](Program::Inside inside) {
                        sigset_t awaited;
                        ::sigemptyset(&awaited);
                        ::sigaddset(&awaited, SIGUSR1);
                        ::sigprocmask(SIG_BLOCK, &awaited, nullptr);
                        inside.guardian.beat();
                        int signal = 0;
                        ::sigwait(&awaited, &signal);
                        for (;;)
                            inside.guardian.update(0, inside.link,
                                                   {.seen = short_stop, .unseen = short_stop, .seen_for = a_moment});
                    },
                    {.patience = 50ms});
    const auto all = times(3, long_stop);
    auto got = wire.read(long_stop.front().frame.size);
    ::kill(program.pid(), SIGUSR1); // while the others are still to be sent
    const auto others = wire.read(all.size() - got.size(), 2'000);
    got.insert(got.end(), others.begin(), others.end());
    EXPECT_EQ(got, all);
}

TEST(GuardianTest, AHungProgramIsStoppedFromElsewhereByTheFramesForMotorsThatNobodySees)
{
    const Wire wire;
    const std::array hold{stop_of(1)}, brake{stop_of(2)};
    Program program(wire, StopFrames{.seen = hold, .unseen = brake, .seen_for = a_moment}, forever);
    ASSERT_TRUE(stop_program(program.pid()));
    const auto all = times(3, brake);
    EXPECT_EQ(wire.read(all.size()), all);
}

TEST(GuardianTest, AProgramThatNeverBeatIsLeftAlone)
{
    const Wire wire;
    const std::array stop{stop_of(1)};
    Program program(wire, stop, forever, {.patience = 20ms});
    EXPECT_TRUE(wire.read(1, 300).empty());
}

/// A robot whose one servo answers nothing, and a second line of its guardian.
struct SlowStop {
    const Wire silent, guarded;
    const link::Fd keeper = guarded.keep_open();
    link::RealClock clock;
    std::optional<Guardian> guardian;
    std::optional<Robot> robot;
    std::optional<link::AnyLink> link;

    SlowStop()
    {
        guardian.emplace(Guardian::start({.patience = 500ms}).value());
        const auto file =
            config::parse_robot_file("version = 1\n[bus.s]\nfamily = \"sam\"\n[joint.arm]\nbus = \"s\"\nid = 1\n"
                                     "model = \"SAM-5\"\n",
                                     "arm.toml");
        OpenOptions options{.links = {{"s", silent.uri}}, .guardian = &*guardian};
        options.settings.margin_at_first = options.settings.margin_least = options.settings.margin_most = 1s;
        robot.emplace(Robot::open(file.value(), link::Links::system(), clock, options).value());
        link.emplace(link::Links::system().open(guarded.uri, clock).value());
        const std::array stop{stop_of(1)};
        EXPECT_TRUE(guardian->watch(1, guarded.uri, *link, {.seen = stop, .unseen = stop, .seen_for = a_moment}));
        guardian->beat();
    }
};

TEST(GuardianTest, ALongStopIsNoProgramThatHangs)
{
    SlowStop slow;
    const TimePoint begun = slow.clock.now();
    EXPECT_EQ(slow.robot->stop().at(0).outcome, Stopped::Outcome::failed);
    EXPECT_GT(slow.clock.now() - begun, 3 * 500ms) << "too short to tell";
    EXPECT_TRUE(slow.guarded.read(1, 0).empty()) << "the guardian took a long stop for a program that hangs";
}

TEST(GuardianTest, AStopFromElsewhereDuringALongStopLeavesThatToTheProgram)
{
    SlowStop slow;
    std::size_t frames = 0;
    for (const auto& request : slow.robot->stop_requests(0))
        frames += request.frame.size;
    std::thread caller([&] {
        (void)slow.silent.read(frames + 1); // the stop is out, and the program asks who obeyed
        const auto said = stop_program(::getpid());
        ASSERT_TRUE(said) << to_sentence(said.error());
        EXPECT_FALSE(said->by_guardian);
    });
    (void)slow.robot->stop();
    caller.join();
    EXPECT_TRUE(slow.guarded.read(1, 0).empty());
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

TEST(GuardianTest, NobodyIsFoundWhereNobodyIsWatched)
{
    const auto said = stop_program(1);
    ASSERT_FALSE(said);
    EXPECT_EQ(said.error().code, Errc::link_not_found);
}

} // namespace
} // namespace sinew::robot::test
