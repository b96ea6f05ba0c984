#include "apps/cli/interrupt.hpp"

#include "apps/cli/terminal.hpp"

#include <array>
#include <csignal>
#include <gtest/gtest.h>
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
    clear_interrupt();
    type("\n");
    EXPECT_EQ(wait_for_line(), Typed::enter);
}

} // namespace
} // namespace sinew::cli
