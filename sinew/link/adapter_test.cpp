#include "sinew/link/adapter.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"

#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

namespace sinew::link {
namespace {

namespace fs = std::filesystem;

/// A small /dev, /sys and /proc with one FTDI adapter as ttyUSB3.
class AdapterTest : public ::testing::Test
{
protected:
    void SetUp() override
    {
        std::string name = (fs::temp_directory_path() / "sinew-adapter-XXXXXX").string();
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        root_ = name;
        write("dev/ttyUSB3", "");
        write("sys/class/tty/ttyUSB3/device/latency_timer", "16\n");
        fs::create_directories(root_ / "dev/serial/by-id");
        fs::create_directory_symlink("../../../../bus/usb-serial/drivers/ftdi_sio",
                                     root_ / "sys/class/tty/ttyUSB3/device/driver");
        fs::create_symlink("../../ttyUSB3", root_ / "dev/serial/by-id/usb-FTDI_A50285BI-if00-port0");
        fs::create_symlink("../../ttyUSB9", root_ / "dev/serial/by-id/usb-gone");
    }
    ~AdapterTest() override { fs::remove_all(root_); }

    void write(const fs::path& path, std::string_view text)
    {
        fs::create_directories((root_ / path).parent_path());
        std::ofstream{root_ / path} << text;
    }
    Roots roots() const
    {
        return {.dev = (root_ / "dev").string(), .sys = (root_ / "sys").string(), .proc = (root_ / "proc").string()};
    }
    std::string device() const { return (root_ / "dev/ttyUSB3").string(); }

    fs::path root_;
};

TEST_F(AdapterTest, IsNamedWithItsDriverAndItsLatency)
{
    const auto adapter = look_at_adapter(device(), roots());
    EXPECT_TRUE(adapter.is_there && adapter.may_open);
    EXPECT_EQ(adapter.driver, "ftdi_sio");
    EXPECT_EQ(adapter.latency_timer_ms, 16);
    EXPECT_EQ(adapter.serial_number, "");
    EXPECT_EQ(adapter.by_id, (root_ / "dev/serial/by-id/usb-FTDI_A50285BI-if00-port0").string());
    EXPECT_TRUE(adapter.holders.empty());
    EXPECT_FALSE(adapter.low_latency.has_value());
}

TEST_F(AdapterTest, IsTheSameUnderTheNameThatStays)
{
    const auto adapter = look_at_adapter((root_ / "dev/serial/by-id/usb-FTDI_A50285BI-if00-port0").string(), roots());
    EXPECT_EQ(adapter.device, fs::canonical(device()).string());
    EXPECT_EQ(adapter.latency_timer_ms, 16);
}

TEST_F(AdapterTest, HasTheSerialNumberOfTheUsbDeviceAboveIt)
{
    write("sys/devices/usb1/1-1/idProduct", "6001\n");
    write("sys/devices/usb1/1-1/serial", "A50285BI\n");
    write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB4/latency_timer", "1\n");
    write("dev/ttyUSB4", "");
    fs::create_directories(root_ / "sys/class/tty/ttyUSB4");
    fs::create_directory_symlink("../../../devices/usb1/1-1/1-1:1.0/ttyUSB4", root_ / "sys/class/tty/ttyUSB4/device");
    const auto adapter = look_at_adapter((root_ / "dev/ttyUSB4").string(), roots());
    EXPECT_EQ(adapter.serial_number, "A50285BI");
    EXPECT_EQ(adapter.latency_timer_ms, 1);
}

TEST_F(AdapterTest, SaysNothingOfADeviceThatIsGone)
{
    const auto adapter = look_at_adapter((root_ / "dev/serial/by-id/usb-gone").string(), roots());
    EXPECT_FALSE(adapter.is_there || adapter.may_open);
    EXPECT_EQ(adapter.driver, "");
}

TEST_F(AdapterTest, OfThePortOfABoardTellsLowLatencyFromTheFlags)
{
    write("sys/class/tty/ttyUSB3/flags", "0x10002040\n");
    EXPECT_EQ(look_at_adapter(device(), roots()).low_latency, true);
    write("sys/class/tty/ttyUSB3/flags", "0x10000040\n");
    EXPECT_EQ(look_at_adapter(device(), roots()).low_latency, false);
}

TEST_F(AdapterTest, NamesTheProgramsThatHaveItOpen)
{
    write("proc/77/comm", "minicom\n");
    write("proc/12/comm", "bash\n");
    fs::create_directories(root_ / "proc/77/fd");
    fs::create_directories(root_ / "proc/12/fd");
    fs::create_symlink(fs::canonical(device()), root_ / "proc/77/fd/3");
    fs::create_symlink("/dev/null", root_ / "proc/12/fd/3");
    const auto adapter = look_at_adapter(device(), roots());
    ASSERT_EQ(adapter.holders.size(), 1U);
    EXPECT_EQ(adapter.holders[0].pid, 77);
    EXPECT_EQ(who_holds(device(), roots()), "minicom (pid 77)");
}

TEST_F(AdapterTest, NamesTheHolderOfTheLockBeforeAllOthers)
{
    struct stat file{};
    ASSERT_EQ(::stat(device().c_str(), &file), 0);
    const auto place = fmt::format("{:02x}:{:02x}:{}", major(file.st_dev), minor(file.st_dev), file.st_ino);
    write("proc/41/comm", "sinew\n");
    write("proc/locks", fmt::format("1: POSIX  ADVISORY  WRITE 40 {0} 0 EOF\n2: FLOCK  ADVISORY  WRITE 41 {0} 0 EOF\n"
                                    "2: -> FLOCK  ADVISORY  WRITE 42 {0} 0 EOF\n",
                                    place));
    EXPECT_EQ(lock_holder(device(), roots())->pid, 41);
    EXPECT_EQ(who_holds(device(), roots()), "sinew (pid 41)");
}

TEST_F(AdapterTest, NamesTheGroupThatMayOpenIt)
{
    ASSERT_EQ(::chmod(device().c_str(), 0660), 0);
    if (::geteuid() == 0) {
        ASSERT_EQ(::chown(device().c_str(), 0, 20), 0); // dialout has 20 on Debian
        EXPECT_EQ(look_at_adapter(device(), roots()).group, "dialout");
    }
    ASSERT_EQ(::chmod(device().c_str(), 0600), 0);
    EXPECT_EQ(look_at_adapter(device(), roots()).group, "");
}

TEST(AdapterOfThisMachine, IsFoundByTheHolderOfItsLock)
{
    RealClock clock;
    const auto master = PtyMaster::open(9600, clock);
    ASSERT_TRUE(master);
    EXPECT_FALSE(lock_holder((*master)->device()).has_value());
    const Fd fd{::open((*master)->device().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
    ASSERT_EQ(::flock(fd.get(), LOCK_EX | LOCK_NB), 0);
    ASSERT_TRUE(lock_holder((*master)->device()).has_value());
    EXPECT_EQ(lock_holder((*master)->device())->pid, ::getpid());
    const auto adapter = look_at_adapter((*master)->device());
    EXPECT_TRUE(std::ranges::any_of(adapter.holders, [](const Holder& h) { return h.pid == ::getpid(); }));
    EXPECT_FALSE(driver_settings(fd.get()).rs485.has_value()) << "a pseudo terminal has no such setting";
}

} // namespace
} // namespace sinew::link
