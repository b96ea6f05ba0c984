#include "sinew/bus/real_time.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace sinew::bus {
namespace {

/// As `ulimit` shows it.
std::string limit(__rlimit_resource which, rlim_t unit)
{
    rlimit now{};
    if (::getrlimit(which, &now) != 0)
        return "unknown";
    return now.rlim_cur == RLIM_INFINITY ? "unlimited" : fmt::format("{}", now.rlim_cur / unit);
}

std::string why_unlocked(int problem)
{
    if (problem == EPERM || problem == ENOMEM || problem == EAGAIN)
        return fmt::format(
            "memory is not locked: that needs the capability CAP_IPC_LOCK or a higher limit on locked memory, "
            "which is {} kB ('ulimit -l', memlock in /etc/security/limits.conf)",
            limit(RLIMIT_MEMLOCK, 1024));
    return fmt::format("memory is not locked: {}", std::strerror(problem));
}

std::string why_not_first(int priority, int problem)
{
    if (problem == EINVAL)
        return fmt::format("priority {} does not exist: SCHED_FIFO has {} … {}", priority,
                           sched_get_priority_min(SCHED_FIFO), sched_get_priority_max(SCHED_FIFO));
    if (problem == EPERM)
        return fmt::format(
            "priority {} is not given: that needs the capability CAP_SYS_NICE or a higher limit, which is {} "
            "('ulimit -r', rtprio in /etc/security/limits.conf); in a container its control group must allow "
            "real time as well",
            priority, limit(RLIMIT_RTPRIO, 1));
    return fmt::format("priority {} is not given: {}", priority, std::strerror(problem));
}

std::string why_elsewhere(int processor, int problem)
{
    cpu_set_t allowed;
    if (problem != EINVAL || ::sched_getaffinity(0, sizeof allowed, &allowed) != 0)
        return fmt::format("the thread is not bound to processor {}: {}", processor, std::strerror(problem));
    std::string list;
    for (int i = 0; i < CPU_SETSIZE; ++i)
        if (CPU_ISSET(i, &allowed))
            list += fmt::format("{}{}", list.empty() ? "" : ", ", i);
    return fmt::format(
        "the thread is not bound to processor {}: there is none such, or it is not allowed here; allowed now: {}",
        processor, list);
}

/// 0 or errno.
int bind_to(int processor)
{
    if (processor < 0 || processor >= CPU_SETSIZE)
        return EINVAL;
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(processor, &only);
    return ::sched_setaffinity(0, sizeof only, &only) == 0 ? 0 : errno;
}

int run_first(int priority)
{
    const sched_param parameter{.sched_priority = priority};
    return ::sched_setscheduler(0, SCHED_FIFO, &parameter) == 0 ? 0 : errno;
}

} // namespace

std::vector<Refusal> apply(const RealTime& wanted)
{
    std::vector<Refusal> refused;
    if (wanted.processor != -1)
        if (const int problem = bind_to(wanted.processor); problem != 0)
            refused.push_back({"processor", problem, why_elsewhere(wanted.processor, problem)});
    if (wanted.priority != 0)
        if (const int problem = run_first(wanted.priority); problem != 0)
            refused.push_back({"priority", problem, why_not_first(wanted.priority, problem)});
    if (wanted.lock_memory && ::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        const int problem = errno;
        refused.push_back({"lock_memory", problem, why_unlocked(problem)});
    }
    return refused;
}

} // namespace sinew::bus
