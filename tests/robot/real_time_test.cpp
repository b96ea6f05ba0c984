#include "sinew/sim/links.hpp"
#include "tests/robot/rig.hpp"

#include <algorithm>
#include <sched.h>
#include <thread>

/// `[bus.NAME.realtime]` over pseudo terminals, in real time; nothing here depends on how long it takes.
namespace sinew::robot::test {
namespace {

using namespace std::chrono_literals;

/// Of the processors that this program may use.
int last_allowed()
{
    cpu_set_t allowed;
    EXPECT_EQ(::sched_getaffinity(0, sizeof allowed, &allowed), 0);
    int last = -1;
    for (int i = 0; i < CPU_SETSIZE; ++i)
        if (CPU_ISSET(i, &allowed))
            last = i;
    return last;
}

config::Marked<std::int64_t> number(std::int64_t value)
{
    return {value, {}};
}

class RobotRealTime : public testing::Test
{
protected:
    void open(const config::RobotFile& host)
    {
        sim::add(links_, worlds_);
        OpenOptions options;
        for (const auto& bus : host.buses)
            options.links[bus.name] = "sim:robots/demo.toml?clock=real#" + bus.name;
        auto opened = Robot::open(host, links_, clock_, options);
        ASSERT_TRUE(opened.has_value()) << to_sentence(opened.error());
        robot_.emplace(std::move(*opened));
    }
    /// A turn in a thread of its own; where that may run afterwards.
    cpu_set_t cycle_in_a_thread(int turns = 1)
    {
        cpu_set_t bound;
        std::thread([&] {
            for (int i = 0; i < turns; ++i)
                (void)robot_->cycle(); // it is not enabled: every turn only reads
            ::sched_getaffinity(0, sizeof bound, &bound);
        }).join();
        return bound;
    }
    std::vector<std::string> said() const
    {
        std::vector<std::string> all;
        for (const auto& incident : robot_->incidents())
            all.push_back(incident.says);
        return all;
    }

    sim::Worlds worlds_;
    link::RealClock clock_;
    link::Links links_ = link::Links::system();
    std::optional<Robot> robot_;
};

TEST_F(RobotRealTime, TheThreadThatDrivesRunsWhereTheRobotFileSays)
{
    auto host = demo();
    const int last = last_allowed();
    host.buses[1].realtime.processor = number(last);
    open(host);
    const cpu_set_t bound = cycle_in_a_thread();
    EXPECT_EQ(CPU_COUNT(&bound), 1);
    EXPECT_TRUE(CPU_ISSET(last, &bound));
    EXPECT_EQ(said(), std::vector<std::string>{});
}

TEST_F(RobotRealTime, TheLoopOfTheLibraryRunsWhereTheRobotFileSays)
{
    auto host = demo();
    host.buses[0].realtime.processor = number(last_allowed());
    open(host);
    cpu_set_t bound;
    std::thread([&] {
        (void)robot_->run(1ms, {}, clock_.now());
        ::sched_getaffinity(0, sizeof bound, &bound);
    }).join();
    EXPECT_EQ(CPU_COUNT(&bound), 1);
}

TEST_F(RobotRealTime, WhatIsRefusedIsSaidOnceAndTheRobotGoesOn)
{
    auto host = demo();
    host.buses[2].realtime.processor = number(5'000'000'000);
    open(host);
    cycle_in_a_thread(3);
    ASSERT_EQ(said().size(), 1U);
    EXPECT_TRUE(said()[0].starts_with("bus legs: the thread is not bound to processor ")) << said()[0];
    EXPECT_EQ(robot_->fault(), nullptr);
    EXPECT_GT(robot_->buses()[2]->conversation().counters().requests, 0U);
    cycle_in_a_thread();
    EXPECT_EQ(said().size(), 2U) << "another thread drives, and has not got it either";
}

TEST_F(RobotRealTime, TwoBusesThatWantDifferentProcessorsAreTold)
{
    auto host = demo();
    host.buses[0].realtime.processor = number(last_allowed());
    host.buses[1].realtime.processor = number(last_allowed() + 1);
    host.buses[2].realtime.processor = number(last_allowed());
    open(host);
    const cpu_set_t bound = cycle_in_a_thread();
    EXPECT_TRUE(CPU_ISSET(last_allowed(), &bound));
    EXPECT_EQ(said(), std::vector<std::string>{fmt::format(
                          "bus waist: processor {} is not taken: one thread drives all buses, and bus left has it on "
                          "processor {}",
                          last_allowed() + 1, last_allowed())});
}

TEST(RobotVirtualTime, AsksTheSystemForNothing)
{
    auto host = demo();
    host.buses[0].realtime = {.lock_memory = true, .priority = number(99), .processor = number(100'000)};
    Rig rig(demo(), host);
    rig.enable();
    ASSERT_TRUE(rig.robot->cycle());
    EXPECT_TRUE(rig.robot->incidents().empty());
    EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER);
}

} // namespace
} // namespace sinew::robot::test
