#include "apps/cli/interrupt.hpp"

#include "apps/cli/terminal.hpp"

#include <array>
#include <csignal>
#include <filesystem>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

/// Stdin is a pipe into which nobody writes until a test does.
class InterruptTest : public testing::Test
{
protected:
    InterruptTest()
    {
        before_ = ::dup(STDIN_FILENO);
        EXPECT_EQ(::pipe(ends_.data()), 0);
        ::dup2(ends_[0], STDIN_FILENO);
        catch_interrupts();
    }
    ~InterruptTest() override
    {
        clear_interrupt();
        ::dup2(before_, STDIN_FILENO);
        for (const int fd : {before_, ends_[0], ends_[1]})
            ::close(fd);
    }
    void type(std::string_view text) { EXPECT_EQ(::write(ends_[1], text.data(), text.size()), std::ssize(text)); }

private:
    int before_ = -1;
    std::array<int, 2> ends_{};
};

/// Whether what wakes whoever waits can be read.
bool some_event_waits()
{
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
        std::error_code none;
        if (std::filesystem::read_symlink(entry.path(), none) != "anon_inode:[eventfd]")
            continue;
        pollfd event{.fd = std::stoi(entry.path().filename()), .events = POLLIN, .revents = 0};
        if (::poll(&event, 1, 0) > 0)
            return true;
    }
    return false;
}

TEST_F(InterruptTest, ACtrlCThatCameJustBeforeSomebodyWaitsIsNotMissed)
{
    ::alarm(60); // instead of waiting for ever
    (void)std::raise(SIGINT);
    EXPECT_EQ(wait_for_line(), Typed::end);
    ::alarm(0);
    EXPECT_TRUE(interrupted());
}

TEST_F(InterruptTest, OneThatWasTakenBackEndsNoWait)
{
    (void)std::raise(SIGINT);
    EXPECT_TRUE(some_event_waits());
    clear_interrupt();
    EXPECT_FALSE(some_event_waits());
    type("\n");
    EXPECT_EQ(wait_for_line(), Typed::enter);
}

} // namespace
} // namespace sinew::cli
