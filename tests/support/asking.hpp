#pragma once
#include <atomic>
#include <csignal>
#include <functional>
#include <pthread.h>
#include <thread>

/// Who asks for what may be asked for from anywhere, such as a stop. The thread that drives calls these; each returns
/// when it was asked.
namespace sinew::test {

using Ask = std::function<void()>;

/// Does that in a handler of SIGUSR1, once, and puts back the handler before it at the end. One at a time.
class InSignalHandler
{
public:
    explicit InSignalHandler(const Ask& ask)
    {
        asks_now = &ask;
        struct sigaction action{};
        action.sa_handler = handle;
        sigemptyset(&action.sa_mask);
        sigaction(SIGUSR1, &action, &before_);
    }
    ~InSignalHandler() { sigaction(SIGUSR1, &before_, nullptr); }
    InSignalHandler(const InSignalHandler&) = delete;
    InSignalHandler& operator=(const InSignalHandler&) = delete;

    static bool has_asked() { return asks_now.load() == nullptr; }

private:
    static void handle(int) { (*asks_now.exchange(nullptr))(); }

    static inline std::atomic<const Ask*> asks_now{nullptr};
    struct sigaction before_{};
};

inline void ask_here(const Ask& ask)
{
    ask();
}

inline void ask_from_another_thread(const Ask& ask)
{
    std::thread(ask).join();
}

/// Of this thread, sent by another one.
inline void ask_from_a_signal_handler(const Ask& ask)
{
    const InSignalHandler handler(ask);
    const pthread_t drives = pthread_self();
    std::thread([&] { pthread_kill(drives, SIGUSR1); }).join();
    while (!InSignalHandler::has_asked())
        std::this_thread::yield();
}

} // namespace sinew::test
