#include "sinew/link/tcp.hpp"

#include "sinew/link/link_test_support.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace sinew::link {
namespace {

int option_of(int fd, int level, int option)
{
    int value = -1;
    socklen_t size = sizeof value;
    EXPECT_EQ(::getsockopt(fd, level, option, &value, &size), 0);
    return value;
}

class Tcp : public ::testing::Test
{
protected:
    void SetUp() override
    {
        auto opened = TcpListener::open("127.0.0.1", 0, clock_);
        ASSERT_TRUE(opened) << to_sentence(opened.error());
        box_ = std::move(*opened);
    }

    auto open(std::string_view text, Clock& clock) { return open_tcp(*parse_uri(text), clock); }
    auto open(std::string_view options = "")
    {
        return open(fmt::format("tcp://127.0.0.1:{}{}", box_->port(), options), clock_);
    }
    /// Lets the box see that a client came or went.
    bool box_sees(bool client)
    {
        const TimePoint deadline = clock_.now() + test::patience;
        for (;;) {
            std::array<std::uint8_t, 64> into;
            EXPECT_TRUE(box_->read(into));
            if (box_->has_client() == client)
                return true;
            if (clock_.now() >= deadline)
                return false;
            const Handle handles[] = {{.fd = box_->handle()}};
            clock_.wait(handles, deadline);
        }
    }
    std::string refusal(std::string_view text, Errc code)
    {
        const auto link = open(text, clock_);
        if (link)
            return "accepted";
        EXPECT_EQ(link.error().code, code) << text;
        return to_sentence(link.error());
    }

    RealClock clock_;
    std::unique_ptr<TcpListener> box_;
};

TEST_F(Tcp, CarriesBytesBothWays)
{
    auto link = open();
    ASSERT_TRUE(link) << to_sentence(link.error());
    ASSERT_TRUE(box_sees(true));
    const std::string all{"\x00\xFF\r\n\x11\x13", 6};
    ASSERT_EQ((*link)->write(test::bytes(all)).value(), all.size());
    EXPECT_EQ(test::read(*box_, clock_, all.size()), all);
    ASSERT_EQ(box_->write(test::bytes(all)).value(), all.size());
    EXPECT_EQ(test::read(**link, clock_, all.size()), all);
}

TEST_F(Tcp, SendsRequestsWithoutDelay)
{
    auto link = open();
    ASSERT_TRUE(link);
    EXPECT_NE(option_of((*link)->handle(), IPPROTO_TCP, TCP_NODELAY), 0);
}

/// What notices a box that lost its power: silent for 5 s, then asked three times, a second apart.
void expect_keep_alive(int fd)
{
    EXPECT_NE(option_of(fd, SOL_SOCKET, SO_KEEPALIVE), 0);
    EXPECT_EQ(option_of(fd, IPPROTO_TCP, TCP_KEEPIDLE), 5);
    EXPECT_EQ(option_of(fd, IPPROTO_TCP, TCP_KEEPINTVL), 1);
    EXPECT_EQ(option_of(fd, IPPROTO_TCP, TCP_KEEPCNT), 3);
    EXPECT_EQ(option_of(fd, IPPROTO_TCP, TCP_USER_TIMEOUT), 8000) << "of what was sent and not acknowledged";
}

TEST_F(Tcp, NoticesABoxThatLostItsPower)
{
    auto link = open();
    ASSERT_TRUE(link);
    expect_keep_alive((*link)->handle());
    ASSERT_TRUE(box_sees(true));
    expect_keep_alive(box_->handle());
}

TEST_F(Tcp, NoticesItAfterALossToo)
{
    const auto reopen = reopen_tcp(*parse_uri(fmt::format("tcp://127.0.0.1:{}", box_->port())), clock_);
    auto link = reopen();
    const TimePoint deadline = clock_.now() + test::patience;
    while (!link && clock_.now() < deadline)
        link = reopen();
    ASSERT_TRUE(link);
    expect_keep_alive(std::get<std::unique_ptr<ByteLink>>(*link)->handle());
}

TEST_F(Tcp, KnowsTheRateOnlyWhenItIsTold)
{
    auto link = open();
    ASSERT_TRUE(link);
    EXPECT_TRUE((*link)->state().open);
    EXPECT_EQ((*link)->state().bit_rate, 0u);
    EXPECT_EQ((*link)->set_bit_rate(9600).error().code, Errc::unsupported);

    auto told = open("?baud=115200");
    ASSERT_TRUE(told);
    EXPECT_EQ((*told)->state().bit_rate, 115200u);
}

TEST_F(Tcp, SwallowsTheEchoOfTheBoxWhenAsked)
{
    auto link = open("?echo=on");
    ASSERT_TRUE(link);
    ASSERT_TRUE(box_sees(true));
    ASSERT_TRUE((*link)->write(test::bytes("ask")));
    ASSERT_TRUE(box_->write(test::bytes("askanswer")));
    EXPECT_EQ(test::read(**link, clock_, 6), "answer");
}

TEST_F(Tcp, IsLostWhenTheBoxCloses)
{
    auto link = open();
    ASSERT_TRUE(link);
    ASSERT_TRUE(box_sees(true));
    box_.reset();
    const auto error = test::read_until_error(**link, clock_);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code, Errc::link_lost);
    EXPECT_FALSE((*link)->state().open);
    EXPECT_EQ((*link)->handle(), -1);
    EXPECT_EQ((*link)->write(test::bytes("x")).error().code, Errc::link_lost);
    EXPECT_EQ((*link)->set_bit_rate(9600).error().code, Errc::link_lost);
}

TEST_F(Tcp, WritingToABoxThatIsGoneEndsInLinkLostAndNoSignal)
{
    auto link = open();
    ASSERT_TRUE(link);
    ASSERT_TRUE(box_sees(true));
    box_.reset();
    // The first write meets a closed socket at the other end, one of the next the reset that comes back.
    std::optional<Error> error;
    EXPECT_TRUE(test::until(clock_, (*link)->handle(), [&] {
        if (const auto written = (*link)->write(test::bytes("x")); !written)
            error = written.error();
        return error.has_value();
    }));
    EXPECT_EQ(error->code, Errc::link_lost);
}

TEST_F(Tcp, BoxServesTheNextClientWhenOneHangsUp)
{
    auto first = open();
    ASSERT_TRUE(first);
    ASSERT_TRUE(box_sees(true));
    auto second = open();
    ASSERT_TRUE(second);
    ASSERT_TRUE((*second)->write(test::bytes("second")));
    first->reset();
    EXPECT_TRUE(box_sees(false));
    EXPECT_EQ(box_->write(test::bytes("to nobody")).value(), 9u);
    EXPECT_TRUE(box_sees(true));
    ASSERT_TRUE(box_->write(test::bytes("hello")));
    EXPECT_EQ(test::read(**second, clock_, 5), "hello");
}

TEST_F(Tcp, IsNotFoundWhereNothingListens)
{
    const auto port = box_->port();
    box_.reset();
    EXPECT_EQ(
        refusal(fmt::format("tcp://127.0.0.1:{}", port), Errc::link_not_found),
        fmt::format("127.0.0.1:{} refuses the connection: the host is there, but nothing listens on this port", port));
}

TEST_F(Tcp, IsNotFoundWhereTheHostIsUnknown)
{
    // .invalid never resolves, RFC 6761
    EXPECT_NE(refusal("tcp://box.invalid:4001", Errc::link_not_found).find("host 'box.invalid' is unknown"),
              std::string::npos);
}

TEST_F(Tcp, IsNotFoundWhenTheHostIsSilentForTwoSeconds)
{
    // A full queue of connections drops every further one without a word.
    Fd full{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(::bind(full.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(::listen(full.get(), 0), 0);
    ASSERT_EQ(::getsockname(full.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    const auto uri = fmt::format("tcp://127.0.0.1:{}", ntohs(address.sin_port));
    const auto taken = open(uri, clock_);
    ASSERT_TRUE(taken);

    test::HurryingClock clock;
    const auto link = open(uri, clock);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::link_not_found);
    EXPECT_NE(to_sentence(link.error()).find("does not answer within 2 s"), std::string::npos);
    EXPECT_EQ(clock.now(), TimePoint{} + tcp_connect_limit);
}

TEST_F(Tcp, NeedsAHostAndAPort)
{
    for (const auto* text : {"tcp://127.0.0.1", "tcp://127.0.0.1:", "tcp://127.0.0.1:0", "tcp://127.0.0.1:70000",
                             "tcp://127.0.0.1:http", "tcp://:4001", "tcp://::1:4001"})
        EXPECT_NE(refusal(text, Errc::bad_uri).find("must be written tcp://HOST:PORT"), std::string::npos) << text;
}

TEST_F(Tcp, BoxCannotHaveAPortThatIsTaken)
{
    const auto second = TcpListener::open("127.0.0.1", box_->port(), clock_);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Errc::link_busy);
    EXPECT_EQ(TcpListener::open("nowhere", 0, clock_).error().code, Errc::bad_argument);
}

/// A wait would hold up the other buses of the program.
class NoWaiting final : public Clock
{
public:
    TimePoint now() const override { return real_.now(); }
    void wait(std::span<const Handle>, TimePoint) override { ADD_FAILURE() << "it waits"; }

private:
    RealClock real_;
};

TEST_F(Tcp, IsReopenedWithoutWaiting)
{
    NoWaiting clock;
    const auto port = box_->port();
    const auto reopen = reopen_tcp(*parse_uri(fmt::format("tcp://127.0.0.1:{}?baud=9600", port)), clock);
    box_.reset();
    for (int i = 0; i < 3; ++i) {
        const auto gone = reopen();
        ASSERT_FALSE(gone);
        EXPECT_EQ(gone.error().code, Errc::link_not_found) << to_sentence(gone.error());
    }
    auto listening = TcpListener::open("127.0.0.1", port, clock_);
    ASSERT_TRUE(listening) << to_sentence(listening.error());
    box_ = std::move(*listening);
    auto link = reopen();
    for (const TimePoint end = clock_.now() + test::patience; !link && clock_.now() < end;)
        link = reopen();
    ASSERT_TRUE(link) << to_sentence(link.error());
    auto& bytes = *std::get<std::unique_ptr<ByteLink>>(*link);
    EXPECT_EQ(bytes.state().bit_rate, 9600U);
    ASSERT_TRUE(bytes.write(test::bytes("again")));
    EXPECT_EQ(test::read(*box_, clock_, 5), "again");
}

TEST_F(Tcp, ReopensAgainAndAgain)
{
    NoWaiting clock;
    const auto reopen = reopen_tcp(*parse_uri(fmt::format("tcp://127.0.0.1:{}", box_->port())), clock);
    for (int i = 0; i < 5; ++i) {
        auto link = reopen();
        for (const TimePoint end = clock_.now() + test::patience; !link && clock_.now() < end;)
            link = reopen();
        ASSERT_TRUE(link) << to_sentence(link.error());
        ASSERT_TRUE(box_sees(true));
        *link = std::unique_ptr<ByteLink>{};
        ASSERT_TRUE(box_sees(false));
    }
}

} // namespace
} // namespace sinew::link
