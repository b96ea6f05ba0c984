#include "apps/cli/session.hpp"

#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

bool has_open(int pid, const std::string& path)
{
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd", none))
        if (const auto place = std::filesystem::read_symlink(entry.path(), none).string();
            place == path || place == path + " (deleted)") // a terminal whose other end is closed
            return true;
    return false;
}

bool comes_true(const std::function<bool()>& what)
{
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10); // for a machine that has other work
    while (!what() && std::chrono::steady_clock::now() < end)
        ::usleep(1000);
    return what();
}

/// Whoever keeps its port open makes an adapter come back under another name.
TEST(MotionGuardTest, ALinkThatIsLostIsClosedInTheGuardianAlthoughNothingCanBeReadAnyMore)
{
    int ends[2];
    char name[64];
    ASSERT_EQ(::openpty(&ends[0], &ends[1], name, nullptr, nullptr), 0);
    ::close(ends[1]);
    Words words;
    words.add("TARGET", std::string("serial:") + name + "?baud=1500000");
    words.add("--family", "sam");
    words.add("--id", "1");
    words.add("--model", "SAM-5");
    const auto device = target(words);
    ASSERT_TRUE(device) << to_sentence(device.error());
    Session session;
    ASSERT_TRUE(session.guard(*device));
    auto driven = drive(session, *device);
    ASSERT_TRUE(driven) << to_sentence(driven.error());
    driven->guard = std::make_unique<MotionGuard>(*session.guardian(), driven->device);
    const auto watched = driven->guard->update(*driven);
    ASSERT_TRUE(watched) << to_sentence(watched.error());
    const int guardian = session.guardian()->process_id();
    ASSERT_TRUE(comes_true([&] { return has_open(guardian, name); }));
    ::close(ends[0]);
    EXPECT_FALSE(read_state(*driven, actuator::Depth::motion));
    EXPECT_TRUE(comes_true([&] { return !has_open(guardian, name); }));
}

} // namespace
} // namespace sinew::cli
