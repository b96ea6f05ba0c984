#include "sinew/bus/real_time.hpp"

#include <cerrno>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

namespace sinew::bus {
namespace {

/// In a thread of its own, so that the others keep what they have.
std::vector<Refusal> in_a_thread(const RealTime& wanted, cpu_set_t* bound = nullptr)
{
    std::vector<Refusal> refused;
    std::thread([&] {
        refused = apply(wanted);
        if (bound != nullptr)
            ::sched_getaffinity(0, sizeof *bound, bound);
    }).join();
    return refused;
}

/// Under a sanitizer `mlockall` does nothing and says that it did it.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SINEW_LOCKS_NOTHING true
#endif
#endif
#ifdef SINEW_LOCKS_NOTHING
constexpr bool locks_nothing = true;
#else
constexpr bool locks_nothing = false;
#endif

/// The exit code of a process that has been left without rights.
[[noreturn]] void ask_for_all_without_rights()
{
    const rlimit none{};
    ::setrlimit(RLIMIT_MEMLOCK, &none);
    ::setrlimit(RLIMIT_RTPRIO, &none);
    constexpr uid_t nobody = 65534;
    if (::geteuid() == 0 && ::setuid(nobody) != 0)
        ::_exit(100);
    for (const auto& one : apply({.lock_memory = true, .priority = 50}))
        fprintf(stderr, "%s: %s\n", one.option.c_str(), one.reason.c_str());
    ::_exit(0);
}

TEST(RealTime, AsksForNothingUnlessToldTo)
{
    EXPECT_TRUE(apply({}).empty());
    EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER);
}

TEST(RealTime, BindsTheThreadToItsProcessor)
{
    cpu_set_t allowed, bound;
    ASSERT_EQ(::sched_getaffinity(0, sizeof allowed, &allowed), 0);
    int last = -1;
    for (int i = 0; i < CPU_SETSIZE; ++i)
        if (CPU_ISSET(i, &allowed))
            last = i;
    EXPECT_TRUE(in_a_thread({.processor = last}, &bound).empty());
    EXPECT_EQ(CPU_COUNT(&bound), 1);
    EXPECT_TRUE(CPU_ISSET(last, &bound));
}

TEST(RealTime, SaysWhichProcessorsThereAre)
{
    for (const int processor : {CPU_SETSIZE - 1, CPU_SETSIZE, -2}) {
        const auto refused = in_a_thread({.processor = processor});
        ASSERT_EQ(refused.size(), 1U) << processor;
        EXPECT_EQ(refused[0].option, "processor");
        EXPECT_EQ(refused[0].problem, EINVAL);
        EXPECT_NE(refused[0].reason.find("allowed now: "), std::string::npos) << refused[0].reason;
    }
}

TEST(RealTime, SaysWhichPrioritiesThereAre)
{
    for (const int priority : {100, -1}) {
        const auto refused = in_a_thread({.priority = priority});
        ASSERT_EQ(refused.size(), 1U) << priority;
        EXPECT_EQ(refused[0].option, "priority");
        EXPECT_EQ(refused[0].reason, "priority " + std::to_string(priority) + " does not exist: SCHED_FIFO has 1 … 99");
    }
}

TEST(RealTimeDeathTest, SaysWhichRightIsMissingForEachThatIsRefused)
{
    std::string expected = "priority: priority 50 is not given: .*CAP_SYS_NICE.*limit, which is 0 ";
    if (!locks_nothing)
        expected += "[^\n]*\nlock_memory: memory is not locked: .*CAP_IPC_LOCK.* which is 0 kB";
    EXPECT_EXIT(ask_for_all_without_rights(), testing::ExitedWithCode(0), expected);
}

} // namespace
} // namespace sinew::bus
