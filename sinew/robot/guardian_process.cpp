#include "sinew/link/descriptor.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/guardian_memory.hpp"
#include "sinew/robot/stillness.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <vector>

// What runs in the guardian. It was forked from a program without threads, so the heap may be used.
namespace sinew::robot::guardian {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto beat_period = 100ms;
constexpr auto time_to_obey = 200ms; // for a program that is asked to stop
constexpr auto time_to_ask = 3s;     // for it to find out who obeyed, behind its frames
static_assert(time_to_ask > longest_rest + rest_after_relief);
constexpr auto bus_time = 100ms;      // for a descriptor that takes no more
constexpr int rounds = 3;             // a frame may meet another one, or end half a frame that the program began
constexpr int most_tries = 8;         // to take frames that a program which lives writes meanwhile
constexpr auto between_rounds = 20ms; // silence ends whatever a device had heard of a frame

/// One bus while it is stopped.
struct Sending {
    const Pieces* pieces = nullptr;
    int fd = -1;
    bool refused = false; ///< a frame was not taken
    std::size_t next = 0;
    std::size_t written = 0; ///< bytes of that one
    Clock::time_point due{};
    Clock::time_point give_up{};

    bool done() const { return pieces == nullptr || next >= pieces->count; }
};

class Watch
{
public:
    Watch(Memory& memory, int program, int socket, int listener, Duration patience)
        : memory_(memory), program_(program), socket_(socket), listener_(listener), patience_(patience)
    {
#ifdef SYS_pidfd_open
        // Tells the end of the program also where a child of it has inherited its end of the socket.
        program_ends_ = link::Fd(static_cast<int>(::syscall(SYS_pidfd_open, program, 0)));
#endif
    }

    void run()
    {
        while (serve_program()) {
            memory_.watch_beats.fetch_add(1, std::memory_order_relaxed);
            serve_callers();
            look_for_beats();
            wait();
        }
    }

private:
    /// False when the program has ended, and all is done about it.
    bool serve_program()
    {
        const bool has_ended = ended(); // asked before the last letter is read
        for (;;) {
            Letter letter;
            iovec place{.iov_base = &letter, .iov_len = sizeof letter};
            alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
            msghdr message{};
            message.msg_iov = &place;
            message.msg_iovlen = 1;
            message.msg_control = control.data();
            message.msg_controllen = control.size();
            const ssize_t size = ::recvmsg(socket_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
            if (size == static_cast<ssize_t>(sizeof letter)) {
                if (letter.word == Word::dismiss)
                    return false;
                obey(letter, message);
                continue;
            }
            if (size < 0 && errno == EINTR)
                continue;
            if (size < 0 && errno == EAGAIN && !has_ended)
                return true;
            stop_all(fmt::format("the program with process id {} ended without stopping its motors", program_));
            return false;
        }
    }

    bool ended() const
    {
        pollfd watched{.fd = program_ends_.get(), .events = POLLIN, .revents = 0};
        return program_ends_ && ::poll(&watched, 1, 0) > 0;
    }

    void obey(const Letter& letter, msghdr& message)
    {
        link::Fd fd;
        if (const cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr && header->cmsg_type == SCM_RIGHTS) {
            int number = -1;
            std::memcpy(&number, CMSG_DATA(header), sizeof number);
            fd = link::Fd(number);
        }
        if (letter.bus < most_buses)
            links_[letter.bus] = std::move(fd); // and the old one is closed
    }

    void look_for_beats()
    {
        const auto beats = memory_.beats.load(std::memory_order_relaxed);
        const auto now = Clock::now();
        if (beats != beats_ || beats == 0) {
            beats_ = beats;
            beaten_at_ = now;
            told_ = false;
        } else if (patience_ > Duration{} && now - beaten_at_ > patience_ && !told_) {
            told_ = true;
            memory_.stop_asked.store(true, std::memory_order_release);
            stop_all(
                fmt::format("the program with process id {} gave no sign for {:g} s", program_, seconds(patience_)));
        }
    }

    // ---- `sinew stop` ----

    void serve_callers()
    {
        while (link::Fd caller{listener_ ? ::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC) : -1})
            callers_.push_back(std::move(caller));
        for (link::Fd& caller : callers_) {
            std::array<char, 16> word{};
            const ssize_t size = ::recv(caller.get(), word.data(), word.size(), MSG_DONTWAIT);
            if (size < 0 && errno == EAGAIN)
                continue;
            if (size > 0)
                answer(caller, std::string_view(word.data(), static_cast<std::size_t>(size)));
            caller = {};
        }
        std::erase_if(callers_, [](const link::Fd& caller) { return !caller; });
    }

    void answer(const link::Fd& caller, std::string_view word)
    {
        std::string out;
        if (word == "who")
            for (std::size_t i = 0; i < most_buses; ++i)
                out += links_[i] ? fmt::format("{}\n", memory_.buses[i].link.data()) : "";
        if (word == "stop")
            out = stop_for_caller();
        static_cast<void>(::send(caller.get(), out.data(), out.size(), MSG_NOSIGNAL));
    }

    /// Who did it, and a line for each bus: outcome, link, words.
    std::string stop_for_caller()
    {
        for (Bus& bus : memory_.buses)
            note(bus, StoppedBus::Outcome::sent, "");
        memory_.stop_begun.store(false, std::memory_order_release);
        memory_.stop_done.store(false, std::memory_order_release);
        memory_.stop_asked.store(true, std::memory_order_release);
        const bool begun = becomes_true(memory_.stop_begun, time_to_obey);
        const bool done = begun && becomes_true(memory_.stop_done, time_to_ask);
        const bool obeyed = done || (begun && !ended());
        if (!obeyed)
            stop_all({});
        else if (!done)
            for (Bus& bus : memory_.buses)
                note(bus, StoppedBus::Outcome::failed, "it did not find out in time whether its devices obeyed");
        std::string out = obeyed ? "program\n" : "guardian\n";
        for (const Bus& bus : memory_.buses)
            if (bus.link.front() != '\0')
                out += fmt::format("{}\t{}\t{}\n", bus.outcome.load(std::memory_order_acquire), bus.link.data(),
                                   bus.says.data());
        return out;
    }

    bool becomes_true(const std::atomic<bool>& flag, Clock::duration within) const
    {
        const auto until = Clock::now() + within;
        while (!flag.load(std::memory_order_acquire) && !memory_.stop_done.load(std::memory_order_acquire)) {
            if (Clock::now() >= until || ended())
                return false;
            ::poll(nullptr, 0, 1);
        }
        return true;
    }

    static void note(Bus& bus, StoppedBus::Outcome outcome, std::string_view says)
    {
        bus.says.fill('\0');
        says.copy(bus.says.data(), bus.says.size() - 1);
        bus.outcome.store(static_cast<std::uint8_t>(outcome), std::memory_order_release);
    }

    // ---- the stop ----

    void stop_all(std::string why)
    {
        std::size_t buses = 0;
        take_the_frames();
        for (int round = 0; round < rounds; ++round) {
            if (round > 0)
                ::poll(nullptr, 0, static_cast<int>(std::chrono::milliseconds(between_rounds).count()));
            buses = send_round();
        }
        if (!why.empty() && buses > 0)
            fmt::print(stderr, "sinew: {}; its guardian sent the stop on {} {}\n", why, buses,
                       buses == 1 ? "bus" : "buses");
    }

    /// Once for all rounds: a program that lives after all writes others meanwhile, and a motor that was told to hold
    /// must not be told to brake because it took a while.
    void take_the_frames()
    {
        const Clock::duration now = Clock::now().time_since_epoch();
        for (std::size_t i = 0; i < most_buses; ++i)
            for (int tries = 0; tries < most_tries && !take_the_frames_of(i, now); ++tries) {
            }
    }

    /// Whether nothing was written over them meanwhile.
    bool take_the_frames_of(std::size_t i, Clock::duration now)
    {
        const Bus& bus = memory_.buses[i];
        const auto written = bus.written.load(std::memory_order_acquire);
        const Stop& stop = bus.stop(written);
        const bool unseen = now > Duration(stop.seen_until_ns);
        frames_[i] = unseen ? stop.unseen : stop.seen;
        std::atomic_thread_fence(std::memory_order_acquire);
        return bus.written.load(std::memory_order_relaxed) == written;
    }

    /// All buses at once, each at its own pace. How many there are.
    std::size_t send_round()
    {
        std::array<Sending, most_buses> all{};
        std::size_t count = 0;
        for (std::size_t i = 0; i < most_buses; ++i) {
            Bus& bus = memory_.buses[i];
            if (!links_[i]) {
                note(bus, StoppedBus::Outcome::failed, "its link is lost");
                continue;
            }
            if (frames_[i].count == 0)
                continue; // its motors have stopped
            all[i] = {.pieces = &frames_[i], .fd = links_[i].get(), .give_up = Clock::now() + bus_time};
            ++count;
        }
        while (!std::ranges::all_of(all, &Sending::done)) {
            for (Sending& one : all)
                send_next(one);
            ::poll(nullptr, 0, 1);
        }
        for (std::size_t i = 0; i < most_buses; ++i)
            if (all[i].refused)
                note(memory_.buses[i], StoppedBus::Outcome::failed, "the line takes nothing");
            else if (links_[i])
                note(memory_.buses[i], StoppedBus::Outcome::sent, "");
        return count;
    }

    static void send_next(Sending& one)
    {
        auto now = Clock::now();
        while (!one.done() && now >= one.due) {
            const Piece& piece = one.pieces->all[one.next];
            const ssize_t size = ::write(one.fd, piece.bytes.data() + one.written, piece.size - one.written);
            if (size < 0 && (errno == EAGAIN || errno == ENOBUFS || errno == EINTR) && now < one.give_up)
                return;
            // The rest of a frame goes out before anything else: half of one would spoil the next.
            if (size > 0) {
                one.written += static_cast<std::size_t>(size);
                if (one.written < piece.size && now < one.give_up)
                    return;
            }
            one.refused = one.refused || one.written < piece.size;
            one.written = 0;
            ++one.next; // a line that is gone takes nothing, and the others must have theirs
            now = Clock::now();
            one.due = now + std::chrono::microseconds(piece.pause_us);
            one.give_up = now + bus_time;
        }
    }

    void wait()
    {
        handles_.clear();
        for (const int fd : {socket_.get(), program_ends_.get(), listener_.get()})
            handles_.push_back({.fd = fd, .events = POLLIN, .revents = 0});
        for (const link::Fd& caller : callers_)
            handles_.push_back({.fd = caller.get(), .events = POLLIN, .revents = 0});
        auto longest = std::chrono::milliseconds(beat_period);
        if (patience_ > Duration{})
            longest = std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(patience_ / 4), 1ms, longest);
        ::poll(handles_.data(), handles_.size(), static_cast<int>(longest.count()));
    }

    Memory& memory_;
    int program_;
    link::Fd socket_, listener_, program_ends_;
    Duration patience_;
    std::array<link::Fd, most_buses> links_{};
    std::vector<Pieces> frames_{most_buses}; ///< of the stop that goes on
    std::vector<link::Fd> callers_;
    std::vector<pollfd> handles_;
    std::uint64_t beats_ = 0;
    Clock::time_point beaten_at_{};
    bool told_ = false;
};

/// The terminal and the shell speak to the program; who waits for the end of its output must not wait for this process.
void leave_the_program(int socket, int listener)
{
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGPIPE, SIGUSR1, SIGUSR2, SIGALRM})
        ::signal(number, SIG_IGN);
    for (const int number : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGCHLD})
        ::signal(number, SIG_DFL);
    ::setsid();
    ::prctl(PR_SET_NAME, "sinew-guardian");
    if (const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC); nothing >= 0) {
        ::dup2(nothing, STDIN_FILENO);
        ::dup2(nothing, STDOUT_FILENO);
    }
    const int low = std::min(socket, listener < 0 ? socket : listener);
    const int high = std::max(socket, listener);
    const auto close_range = [](int first, int last) {
        if (first <= last)
            ::syscall(SYS_close_range, static_cast<unsigned>(first), static_cast<unsigned>(last), 0U);
    };
    close_range(STDERR_FILENO + 1, low - 1);
    close_range(low + 1, high - 1);
    ::syscall(SYS_close_range, static_cast<unsigned>(high + 1), ~0U, 0U);
}

} // namespace

void watch_over(Memory& memory, int program, int socket, int listener, Duration patience)
{
    leave_the_program(socket, listener);
    Watch(memory, program, socket, listener, patience).run();
    ::_exit(0);
}

} // namespace sinew::robot::guardian
