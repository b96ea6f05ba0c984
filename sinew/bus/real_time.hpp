#pragma once
#include <string>
#include <vector>

namespace sinew::bus {

/// What a thread that runs buses may ask of the system so that it is late less often. Nothing of it is asked for by
/// default, and nothing of it is needed.
struct RealTime {
    /// No page of the program is ever fetched again from a disk: what there is and what will be stays in memory. For
    /// the whole program; needs CAP_IPC_LOCK, or a limit on locked memory (`ulimit -l`) beyond all that the program
    /// uses.
    bool lock_memory = false;
    /// SCHED_FIFO with this priority, 1 … 99: runs before every thread without one; 0: as it is. A loop that never
    /// waits then takes a processor for itself. Needs CAP_SYS_NICE, or a limit (`ulimit -r`) of at least the priority.
    int priority = 0;
    /// The only processor that the thread may run on, counted from 0; -1: any.
    int processor = -1;
};

/// Something that was asked for and not given.
struct Refusal {
    std::string option; ///< "lock_memory", "priority" or "processor"
    int problem = 0;    ///< errno
    std::string reason; ///< one sentence: what is missing and what gives it
};

/// Asks for all of it, for the calling thread, and returns what was refused. The rest holds, and so does everything
/// else: a program runs without it as well, only less punctually. Asks the heap; call it before the loop begins.
/// Threads that are started afterwards inherit priority and processor.
std::vector<Refusal> apply(const RealTime& wanted);

} // namespace sinew::bus
