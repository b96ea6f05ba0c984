#include "sinew/link/serial.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"
#include "sinew/link/tty.hpp"

#include <csignal>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace sinew::link {
namespace {

class SerialLink : public ::testing::Test
{
protected:
    void SetUp() override
    {
        auto opened = PtyMaster::open(115200, clock_);
        ASSERT_TRUE(opened) << to_sentence(opened.error());
        master_ = std::move(*opened);
        look_ = Fd{::open(master_->device().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
    }

    auto open(std::uint32_t bit_rate = 115200)
    {
        return open_serial({.device = master_->device(), .bit_rate = bit_rate}, clock_);
    }
    auto open_uri(std::string_view text) { return open_serial(*parse_uri(text), clock_); }

    /// What the device end does all day: read when it is woken.
    bool serve_until(const std::function<bool()>& done)
    {
        return test::until(clock_, master_->handle(), [&] {
            std::array<std::uint8_t, 64> into;
            EXPECT_TRUE(master_->read(into));
            return done();
        });
    }

    bool is_claimed() const
    {
        int claimed = 0;
        EXPECT_EQ(::ioctl(look_.get(), TIOCGEXCL, &claimed), 0);
        return claimed != 0;
    }

    RealClock clock_;
    std::unique_ptr<PtyMaster> master_;
    Fd look_; ///< open from before any claim: opening one now would be refused, and closing it wake the master
};

TEST_F(SerialLink, CarriesEveryByteBothWays)
{
    auto link = open();
    ASSERT_TRUE(link) << to_sentence(link.error());
    std::string all;
    for (int byte = 0; byte < 256; ++byte)
        all += static_cast<char>(byte);
    ASSERT_EQ((*link)->write(test::bytes(all)).value(), all.size());
    EXPECT_EQ(test::read(*master_, clock_, all.size()), all);
    ASSERT_EQ(master_->write(test::bytes(all)).value(), all.size());
    EXPECT_EQ(test::read(**link, clock_, all.size()), all);
}

TEST_F(SerialLink, ReadsNothingFromASilentLineWithoutBlocking)
{
    auto link = open();
    ASSERT_TRUE(link);
    std::array<std::uint8_t, 8> into;
    EXPECT_EQ((*link)->read(into)->count, 0u);
    EXPECT_TRUE((*link)->state().open);
}

TEST_F(SerialLink, SetsAnyRateAndReportsTheOneThatWasReallySet)
{
    for (const std::uint32_t rate : {1500000u, 250000u, 110u, 76800u, 9600u, 3000000u, 1234567u}) {
        auto link = open(rate);
        ASSERT_TRUE(link) << to_sentence(link.error());
        EXPECT_EQ((*link)->state().bit_rate, rate);
        EXPECT_EQ(master_->client_bit_rate(), rate);
    }
}

TEST_F(SerialLink, ChangesTheRateWhileOpen)
{
    auto link = open(1500000);
    ASSERT_TRUE(link);
    EXPECT_EQ((*link)->set_bit_rate(76800).value(), 76800u);
    EXPECT_EQ((*link)->state().bit_rate, 76800u);
    EXPECT_EQ(master_->client_bit_rate(), 76800u);
    const auto none = (*link)->set_bit_rate(0);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Errc::unsupported);
    EXPECT_EQ(master_->client_bit_rate(), 76800u);
}

TEST_F(SerialLink, ThrowsAwayWhatWasMeantForTheProgramBefore)
{
    ASSERT_TRUE(open());
    ASSERT_EQ(master_->write(test::bytes("old")).value(), 3u);
    auto link = open();
    ASSERT_TRUE(link);
    ASSERT_EQ(master_->write(test::bytes("new")).value(), 3u);
    EXPECT_EQ(test::read(**link, clock_, 3), "new");
}

TEST_F(SerialLink, IsBusyUntilTheOtherProgramCloses)
{
    auto first = open();
    ASSERT_TRUE(first);
    EXPECT_TRUE(is_claimed());
    auto second = open();
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Errc::link_busy);
    EXPECT_EQ(to_sentence(second.error()),
              fmt::format("{} is in use by link_test (pid {}); close it first", master_->device(), ::getpid()));
    EXPECT_TRUE(is_claimed()) << "the program that was turned away took the claim of the first along";

    first->reset();
    EXPECT_FALSE(is_claimed());
    second = open();
    EXPECT_TRUE(second);
}

TEST_F(SerialLink, KeepsItsClaimWhileOthersAreTurnedAway)
{
    auto first = open();
    ASSERT_TRUE(first);
    ASSERT_FALSE(open());
    std::array<std::uint8_t, 8> into;
    ASSERT_TRUE(master_->read(into)); // sees the close of the second program
    EXPECT_TRUE(is_claimed());
}

TEST_F(SerialLink, OpensAgainAfterTheOtherProgramWasKilled)
{
    int ready[2];
    ASSERT_EQ(::pipe2(ready, O_CLOEXEC), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        auto link = open();
        const char word = link ? 'y' : 'n';
        if (::write(ready[1], &word, 1) != 1)
            ::_exit(1);
        for (;;)
            ::pause();
    }
    char word = 0;
    ASSERT_EQ(::read(ready[0], &word, 1), 1);
    ASSERT_EQ(word, 'y');
    EXPECT_TRUE(is_claimed());

    ASSERT_EQ(::kill(child, SIGKILL), 0);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    const Handle handles[] = {{.fd = master_->handle()}};
    const TimePoint deadline = clock_.now() + test::patience;
    clock_.wait(handles, deadline);
    EXPECT_LT(clock_.now(), deadline) << "nothing woke the device end, so the claim would stay";
    EXPECT_TRUE(serve_until([&] { return !is_claimed(); }));
    EXPECT_TRUE(open());
    ::close(ready[0]);
    ::close(ready[1]);
}

TEST_F(SerialLink, IsLostWhenTheOtherEndGoesAway)
{
    auto link = open();
    ASSERT_TRUE(link);
    master_.reset();
    const auto error = test::read_until_error(**link, clock_);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, Errc::link_lost);
    EXPECT_NE(to_sentence(*error).find("hung up"), std::string::npos);
    EXPECT_FALSE((*link)->state().open);
    EXPECT_EQ((*link)->handle(), -1) << "an open descriptor keeps the name of the device taken";
    std::array<std::uint8_t, 8> into;
    EXPECT_EQ((*link)->read(into).error().code, Errc::link_lost);
    EXPECT_EQ((*link)->write(test::bytes("x")).error().code, Errc::link_lost);
    EXPECT_EQ((*link)->write({}).error().code, Errc::link_lost);
    EXPECT_EQ((*link)->set_bit_rate(9600).error().code, Errc::link_lost);
}

TEST_F(SerialLink, IsLostWhenAWriteFindsTheOtherEndGone)
{
    auto link = open();
    ASSERT_TRUE(link);
    master_.reset();
    EXPECT_EQ((*link)->write(test::bytes("x")).error().code, Errc::link_lost);
    EXPECT_EQ((*link)->handle(), -1);
}

TEST_F(SerialLink, IsNotFoundWhereNoDeviceIs)
{
    const auto link = open_uri("serial:/dev/ttyNOSUCH?baud=9600");
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::link_not_found);
    EXPECT_NE(to_sentence(link.error()).find("there is no device /dev/ttyNOSUCH"), std::string::npos);
}

TEST_F(SerialLink, FailsOnAFileThatIsNoSerialPort)
{
    const auto link = open_uri("serial:/dev/null?baud=9600");
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::link_failed);
    EXPECT_EQ(to_sentence(link.error()), "/dev/null is not a serial port");
}

TEST_F(SerialLink, NamesTheGroupToJoinWhenItIsNotPermitted)
{
    // Root may open everything, so somebody else tries, and tells how it went through the exit code.
    ASSERT_EQ(::chmod(master_->device().c_str(), 0620), 0);
    if (::geteuid() == 0) {
        ASSERT_EQ(::chown(master_->device().c_str(), 0, 20), 0); // dialout has 20 on Debian
    } else {
        ASSERT_EQ(::chmod(master_->device().c_str(), 0020), 0);
    }
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0))
            ::_exit(2);
        const auto link = open();
        const bool right = !link && link.error().code == Errc::link_denied &&
                           to_sentence(link.error()).find("sudo usermod -aG ") != std::string::npos;
        ::_exit(right ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(SerialLink, AsksForTheRateWhenNoneIsGiven)
{
    const auto link = open_uri("serial:" + master_->device());
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::bad_uri);
    EXPECT_EQ(to_sentence(link.error()),
              fmt::format("'serial:{0}' does not say its bit rate: add ?baud=RATE, such as serial:{0}?baud=115200",
                          master_->device()));
}

TEST_F(SerialLink, LeavesAPseudoTerminalAtItsRateWhenNoneIsGiven)
{
    const auto link = open_uri("pty:" + master_->device());
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ((*link)->state().bit_rate, 115200u);
}

TEST_F(SerialLink, OpensRs485WhereTheDriverLeavesTheDirectionToTheAdapter)
{
    const auto link = open_uri(fmt::format("rs485:{}?baud=250000", master_->device()));
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ(master_->client_bit_rate(), 250000u);
}

TEST_F(SerialLink, SwallowsItsEchoWhenAsked)
{
    auto link = open_uri(fmt::format("rs485:{}?baud=250000&echo=on", master_->device()));
    ASSERT_TRUE(link) << to_sentence(link.error());
    ASSERT_TRUE((*link)->write(test::bytes("ask")));
    ASSERT_TRUE(master_->write(test::bytes("askanswer")));
    EXPECT_EQ(test::read(**link, clock_, 6), "answer");

    const auto wrong = open_uri(fmt::format("rs485:{}?baud=250000&echo=yes", master_->device()));
    ASSERT_FALSE(wrong);
    EXPECT_EQ(to_sentence(wrong.error()), "option echo must be on, off or auto, not 'yes'");
}

TEST_F(SerialLink, FindsOutAboutItsEchoWhenAsked)
{
    auto link = open_uri(fmt::format("serial:{}?baud=250000&echo=auto", master_->device()));
    ASSERT_TRUE(link) << to_sentence(link.error());
    ASSERT_TRUE((*link)->write(test::bytes("ask")));
    ASSERT_TRUE(master_->write(test::bytes("askanswer")));
    EXPECT_EQ(test::read(**link, clock_, 6), "answer");
}

TEST_F(SerialLink, LeavesTheModemLinesAlone)
{
    // HUPCL off: the lines do not fall when the port closes.
    auto link = open();
    ASSERT_TRUE(link);
    termios settings{};
    ASSERT_EQ(::tcgetattr((*link)->handle(), &settings), 0);
    EXPECT_EQ(settings.c_cflag & (HUPCL | CRTSCTS), 0U);
    EXPECT_NE(settings.c_cflag & CLOCAL, 0U);
}

TEST(TtyRate, IsNearWithinTwoPercent)
{
    EXPECT_TRUE(tty::is_near(1500000, 1500000));
    EXPECT_TRUE(tty::is_near(115200, 115384)); // what a CP2102 makes of it
    EXPECT_TRUE(tty::is_near(100, 102));
    EXPECT_TRUE(tty::is_near(100, 98));
    EXPECT_FALSE(tty::is_near(100, 103));
    EXPECT_FALSE(tty::is_near(100, 97));
    EXPECT_FALSE(tty::is_near(3000000, 9600));
    EXPECT_TRUE(tty::is_near(4000000000u, 4000000000u));
}

} // namespace
} // namespace sinew::link
