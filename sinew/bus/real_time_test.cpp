#include "sinew/bus/real_time.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <thread>
#include <unistd.h>

namespace sinew::bus {
namespace {

/// In a thread of its own, so that the others keep what they have.
std::vector<Refusal> in_a_thread(const RealTime& wanted, cpu_set_t* bound = nullptr)
{
    std::vector<Refusal> refused;
    std::thread([&] {
        errno = EBUSY; // what failed before is nothing that is refused now
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

[[noreturn]] void ask_and_exit(const RealTime& wanted)
{
    for (const auto& one : apply(wanted))
        fprintf(stderr, "%s: %s\n", one.option.c_str(), one.reason.c_str());
    ::_exit(0);
}

/// In a process of its own, which has no rights beyond these limits.
[[noreturn]] void ask_for_all_within(rlim_t memory_bytes, rlim_t priority)
{
    const rlimit memory{.rlim_cur = memory_bytes, .rlim_max = memory_bytes};
    const rlimit first{.rlim_cur = priority, .rlim_max = priority};
    ::setrlimit(RLIMIT_MEMLOCK, &memory);
    ::setrlimit(RLIMIT_RTPRIO, &first);
    constexpr uid_t nobody = 65534;
    if (::geteuid() == 0 && ::setuid(nobody) != 0)
        ::_exit(100);
    ask_and_exit({.lock_memory = true, .priority = 50});
}

/// In a process of its own, where the system refuses that call, as a container may.
[[noreturn]] void ask_where_a_call_fails(unsigned call, unsigned problem, const RealTime& wanted)
{
    sock_filter steps[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | problem),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const sock_fprog filter{.len = std::size(steps), .filter = steps};
    if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0)
        ::_exit(100);
    ask_and_exit(wanted);
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

TEST(RealTime, NamesTheProcessorsThatTheThreadMayUseNow)
{
    cpu_set_t allowed;
    ASSERT_EQ(::sched_getaffinity(0, sizeof allowed, &allowed), 0);
    std::string all;
    for (int i = 0; i < CPU_SETSIZE; ++i) {
        if (!CPU_ISSET(i, &allowed))
            continue;
        all += (all.empty() ? "" : ", ") + std::to_string(i);
        std::string reason;
        std::thread([&] {
            ASSERT_TRUE(apply({.processor = i}).empty());
            reason = apply({.processor = CPU_SETSIZE}).at(0).reason;
        }).join();
        EXPECT_TRUE(reason.ends_with("allowed now: " + std::to_string(i))) << reason;
    }
    const std::string reason = in_a_thread({.processor = CPU_SETSIZE}).at(0).reason;
    EXPECT_TRUE(reason.ends_with("allowed now: " + all)) << reason;
}

TEST(RealTime, RefusesNoPriorityThatTheThreadHasGot)
{
    std::vector<Refusal> refused;
    int policy = -1;
    std::thread([&] {
        errno = EBUSY;
        refused = apply({.priority = 1});
        policy = ::sched_getscheduler(0);
    }).join();
    EXPECT_EQ(refused.empty(), policy == SCHED_FIFO) << "where the right is missing it is refused";
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
    EXPECT_EXIT(ask_for_all_within(0, 0), testing::ExitedWithCode(0), expected);
}

TEST(RealTimeDeathTest, SaysHowFarTheLimitsGo)
{
    rlimit most{.rlim_cur = 10, .rlim_max = 10};
    const bool is_raised = ::setrlimit(RLIMIT_RTPRIO, &most) == 0;
    ASSERT_TRUE(is_raised || ::getrlimit(RLIMIT_RTPRIO, &most) == 0);
    const rlim_t priority = std::min<rlim_t>(10, most.rlim_max); // no further where nobody may raise it
    std::string expected = "priority: .*limit, which is " + std::to_string(priority) + " ";
    if (!locks_nothing)
        expected += "[^\n]*\nlock_memory: .*which is 64 kB";
    EXPECT_EXIT(ask_for_all_within(64 * 1024, priority), testing::ExitedWithCode(0), expected);
}

TEST(RealTimeDeathTest, SaysWhyAThreadIsNotBoundToAProcessorThatThereIs)
{
    if (::prctl(PR_GET_SECCOMP) != 0)
        GTEST_SKIP() << "the system can forbid nothing, or does already";
    EXPECT_EXIT(ask_where_a_call_fails(SYS_sched_setaffinity, EPERM, {.processor = 0}), testing::ExitedWithCode(0),
                "processor: the thread is not bound to processor 0: Operation not permitted\n");
}

TEST(RealTimeDeathTest, RefusesNothingThatTheSystemGrants)
{
    if (::prctl(PR_GET_SECCOMP) != 0)
        GTEST_SKIP() << "the system can pretend nothing";
    EXPECT_EXIT(ask_where_a_call_fails(SYS_mlockall, 0, {.lock_memory = true}), testing::ExitedWithCode(0), "^$");
    EXPECT_EXIT(ask_where_a_call_fails(SYS_sched_setscheduler, 0, {.priority = 1}), testing::ExitedWithCode(0), "^$");
    EXPECT_EXIT(ask_where_a_call_fails(SYS_sched_setaffinity, 0, {.processor = 0}), testing::ExitedWithCode(0), "^$");
}

TEST(RealTimeDeathTest, SaysWhatGivesLockedMemoryWhicheverWayItIsRefused)
{
    if (::prctl(PR_GET_SECCOMP) != 0 || locks_nothing)
        GTEST_SKIP() << "the system can forbid nothing, or does already, or the sanitizer locks nothing";
    for (const unsigned problem : {EPERM, ENOMEM, EAGAIN})
        EXPECT_EXIT(ask_where_a_call_fails(SYS_mlockall, problem, {.lock_memory = true}), testing::ExitedWithCode(0),
                    "lock_memory: memory is not locked: .*CAP_IPC_LOCK");
    EXPECT_EXIT(ask_where_a_call_fails(SYS_mlockall, EINVAL, {.lock_memory = true}), testing::ExitedWithCode(0),
                "lock_memory: memory is not locked: Invalid argument\n");
}

} // namespace
} // namespace sinew::bus
