#pragma once
#include "sinew/family/sam/messages.hpp"
#include "sinew/link/links.hpp"
#include "sinew/robot/guardian.hpp"

#include <array>
#include <csignal>
#include <fcntl.h>
#include <functional>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <string>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <vector>

/// What the tests of the guardian share: a line that can be read, and a program with a guardian over it.
namespace sinew::robot::test {

inline constexpr int patience_ms = 20'000; // for a machine that has other work
inline constexpr Duration a_moment = std::chrono::milliseconds(100);

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

inline wire::Request stop_of(int id)
{
    return *wire::make_request(id, sam::SpecialControl{.mode = sam::Mode::passive});
}

inline std::vector<std::uint8_t> times(int count, std::span<const wire::Request> requests)
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
        : Program(wire, StopFrames{.seen = stop, .unseen = stop, .seen_for = a_moment}, life, settings)
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

inline void forever(Program::Inside)
{
    for (;;)
        ::pause();
}

} // namespace sinew::robot::test
