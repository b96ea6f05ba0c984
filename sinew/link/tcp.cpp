#include "sinew/link/tcp.hpp"

#include "sinew/link/echo.hpp"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace sinew::link {
namespace {

struct Address {
    std::string host;
    std::string port;
};

std::expected<Address, Error> split(const Uri& uri)
{
    const std::string_view target = uri.target;
    const auto colon = target.rfind(':');
    std::string_view host = target.substr(0, std::min(colon, target.size()));
    const std::string_view port = colon == std::string_view::npos ? "" : target.substr(colon + 1);
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    else if (host.find(':') != std::string_view::npos)
        host = {}; // which colon of an IPv6 address begins the port cannot be told without the brackets
    std::uint16_t number = 0;
    const auto [end, problem] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (host.empty() || problem != std::errc{} || end != port.data() + port.size() || number == 0)
        return fail(Errc::bad_uri,
                    fmt::format("'{}' must be written tcp://HOST:PORT with a port from 1 to 65535, such as "
                                "tcp://192.168.0.7:4001 or tcp://[fe80::7]:4001",
                                to_string(uri)));
    return Address{.host = std::string{host}, .port = std::string{port}};
}

using AddressList = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

std::expected<AddressList, Error> look_up(const Address& address)
{
    const addrinfo wanted{.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    addrinfo* found = nullptr;
    const int problem = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &wanted, &found);
    if (problem != 0)
        return fail(Errc::link_not_found, fmt::format("host '{}' is unknown ({}); check the name or give its address",
                                                      address.host, ::gai_strerror(problem)));
    return AddressList{found, &::freeaddrinfo};
}

void set(int fd, int level, int option, int value)
{
    ::setsockopt(fd, level, option, &value, sizeof value);
}

/// Requests go out at once; a box that fell silent is given up after 5 s without an answer and three more tries.
void settle(int fd)
{
    set(fd, IPPROTO_TCP, TCP_NODELAY, 1);
    set(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
    set(fd, IPPROTO_TCP, TCP_KEEPIDLE, 5);
    set(fd, IPPROTO_TCP, TCP_KEEPINTVL, 1);
    set(fd, IPPROTO_TCP, TCP_KEEPCNT, 3);
    set(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, 8000);
}

/// A connection that has begun, or errno.
std::expected<Fd, int> begin(const addrinfo& to)
{
    Fd fd{::socket(to.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
    if (!fd)
        return std::unexpected(errno);
    settle(fd.get());
    if (::connect(fd.get(), to.ai_addr, to.ai_addrlen) != 0 && errno != EINPROGRESS)
        return std::unexpected(errno);
    return fd;
}

/// What became of it: 0 connected, EINPROGRESS, or why not.
int progress(const Fd& fd)
{
    int problem = 0;
    socklen_t size = sizeof problem;
    ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &problem, &size);
    if (problem != 0)
        return problem;
    sockaddr_storage peer{};
    socklen_t peer_size = sizeof peer;
    return ::getpeername(fd.get(), reinterpret_cast<sockaddr*>(&peer), &peer_size) == 0 ? 0 : EINPROGRESS;
}

/// Connected, or errno.
std::expected<Fd, int> connect(const addrinfo& to, Clock& clock)
{
    auto fd = begin(to);
    if (!fd)
        return fd;
    const TimePoint deadline = clock.now() + tcp_connect_limit;
    const Handle handles[] = {{.fd = fd->get(), .wants_write = true}};
    for (;;) {
        const int problem = progress(*fd);
        if (problem == 0)
            return fd;
        if (problem != EINPROGRESS)
            return std::unexpected(problem);
        if (clock.now() >= deadline)
            return std::unexpected(ETIMEDOUT);
        clock.wait(handles, deadline);
    }
}

std::unexpected<Error> refuse(const std::string& target, int problem)
{
    switch (problem) {
    case ECONNREFUSED:
        return fail(
            Errc::link_not_found,
            fmt::format("{} refuses the connection: the host is there, but nothing listens on this port", target));
    case ETIMEDOUT:
        return fail(Errc::link_not_found,
                    fmt::format("{} does not answer within {:.0f} s; is it powered and on this network?", target,
                                seconds(tcp_connect_limit)));
    case EHOSTUNREACH:
    case ENETUNREACH:
        return fail(Errc::link_not_found, fmt::format("{} is out of reach ({}); is this machine on its network?",
                                                      target, std::strerror(problem)));
    case EACCES:
    case EPERM:
        return fail(Errc::link_denied, fmt::format("not permitted to connect to {}; a firewall may forbid it", target));
    default:
        return fail(Errc::link_failed, fmt::format("cannot connect to {}: {}", target, std::strerror(problem)));
    }
}

/// What a URI says.
struct Box {
    Address address;
    std::string name;
    std::uint32_t bit_rate = 0;
    Echo echo = Echo::off;
};

std::expected<Box, Error> box_of(const Uri& uri)
{
    const auto baud = uri.number("baud");
    if (!baud)
        return std::unexpected(baud.error());
    const auto echo = echo_option(uri);
    if (!echo)
        return std::unexpected(echo.error());
    const auto address = split(uri);
    if (!address)
        return std::unexpected(address.error());
    return Box{.address = *address, .name = uri.target, .bit_rate = baud->value_or(0), .echo = *echo};
}

class TcpLink final : public ByteLink
{
public:
    TcpLink(Fd fd, std::string name, std::uint32_t bit_rate, const Clock& clock)
        : descriptor_(std::move(fd), std::move(name), clock), bit_rate_(bit_rate)
    {
    }
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        return descriptor_.write(bytes);
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override { return descriptor_.read(into); }
    int handle() const override { return descriptor_.fd(); }
    LinkState state() const override { return {.open = descriptor_.is_open(), .bit_rate = bit_rate_}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t) override
    {
        if (!descriptor_.is_open())
            return std::unexpected(descriptor_.write({}).error());
        return fail(Errc::unsupported,
                    "a TCP link cannot set the bit rate: set it on the box itself and tell it with ?baud=");
    }

private:
    Descriptor descriptor_;
    std::uint32_t bit_rate_;
};

std::unique_ptr<ByteLink> make_link(Fd fd, const Box& box, const Clock& clock)
{
    return with_echo(std::make_unique<TcpLink>(std::move(fd), box.name, box.bit_rate, clock), box.echo, clock);
}

/// A connection that is tried again and again, a step at a time.
class Reconnecting
{
public:
    /// A name is looked up now: later it could take as long as the resolver does.
    Reconnecting(Box box, Clock& clock) : box_(std::move(box)), clock_(&clock), found_(look_up(box_.address)) {}

    std::expected<AnyLink, Error> step()
    {
        if (!found_)
            found_ = look_up(box_.address);
        if (!found_)
            return std::unexpected(found_.error());
        if (!pending_)
            begin_next();
        int problem = pending_ ? progress(*pending_) : pending_.error();
        if (problem == 0)
            return AnyLink{make_link(std::exchange(pending_, std::unexpected(ECONNREFUSED)).value(), box_, *clock_)};
        // The kernel repeats its first packet after a second only; a new connection is faster when the box is back.
        if (problem == EINPROGRESS && clock_->now() < begun_ + patience)
            return fail(Errc::link_not_found, fmt::format("{} has not answered yet", box_.name));
        pending_ = std::unexpected(problem == EINPROGRESS ? ETIMEDOUT : problem);
        return refuse(box_.name, pending_.error());
    }

private:
    static constexpr Duration patience = std::chrono::seconds{1};

    void begin_next()
    {
        at_ = at_ == nullptr || at_->ai_next == nullptr ? found_->get() : at_->ai_next;
        begun_ = clock_->now();
        pending_ = begin(*at_);
    }

    Box box_;
    Clock* clock_;
    std::expected<AddressList, Error> found_;
    const addrinfo* at_ = nullptr;
    std::expected<Fd, int> pending_ = std::unexpected(ECONNREFUSED);
    TimePoint begun_{};
};

} // namespace

std::expected<std::unique_ptr<ByteLink>, Error> open_tcp(const Uri& uri, Clock& clock)
{
    const auto box = box_of(uri);
    if (!box)
        return std::unexpected(box.error());
    const auto found = look_up(box->address);
    if (!found)
        return std::unexpected(found.error());

    int problem = EHOSTUNREACH;
    for (const addrinfo* to = found->get(); to != nullptr; to = to->ai_next) {
        auto fd = connect(*to, clock);
        if (fd)
            return make_link(std::move(*fd), *box, clock);
        problem = fd.error();
    }
    return refuse(uri.target, problem);
}

Reopen reopen_tcp(const Uri& uri, Clock& clock)
{
    auto box = box_of(uri);
    if (!box)
        return [error = box.error()] { return std::unexpected(error); };
    return [state = std::make_shared<Reconnecting>(std::move(*box), clock)] { return state->step(); };
}

std::expected<std::unique_ptr<TcpListener>, Error> TcpListener::open(const std::string& address, std::uint16_t port,
                                                                     const Clock& clock)
{
    const addrinfo wanted{.ai_flags = AI_NUMERICHOST | AI_PASSIVE, .ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    addrinfo* found = nullptr;
    if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0)
        return fail(Errc::bad_argument, fmt::format("'{}' is no address to listen on, such as 127.0.0.1", address));
    const AddressList list{found, &::freeaddrinfo};

    Fd fd{::socket(list->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
    if (fd)
        set(fd.get(), SOL_SOCKET, SO_REUSEADDR, 1);
    if (!fd || ::bind(fd.get(), list->ai_addr, list->ai_addrlen) != 0 || ::listen(fd.get(), 1) != 0)
        return fail(errno == EADDRINUSE ? Errc::link_busy : Errc::link_failed,
                    fmt::format("cannot listen on {} port {}: {}", address, port, std::strerror(errno)));
    sockaddr_storage bound{};
    socklen_t size = sizeof bound;
    if (::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&bound), &size) != 0)
        return fail(Errc::link_failed, fmt::format("cannot listen on {}: {}", address, std::strerror(errno)));
    const auto port_of = bound.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(bound).sin6_port
                                                     : reinterpret_cast<const sockaddr_in&>(bound).sin_port;
    return std::unique_ptr<TcpListener>(new TcpListener(std::move(fd), ntohs(port_of), clock));
}

TcpListener::TcpListener(Fd listener, std::uint16_t port, const Clock& clock)
    : listener_(std::move(listener)), port_(port), clock_(&clock), client_(Fd{}, "the client", clock)
{
}

void TcpListener::accept()
{
    Fd client{::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    if (!client)
        return;
    settle(client.get());
    client_ = Descriptor{std::move(client), "the client", *clock_};
}

std::expected<std::size_t, Error> TcpListener::write(std::span<const std::uint8_t> bytes)
{
    if (!has_client())
        return bytes.size();
    return client_.write(bytes).value_or(bytes.size());
}

std::expected<Arrival, Error> TcpListener::read(std::span<std::uint8_t> into)
{
    if (!has_client())
        accept();
    if (has_client())
        if (const auto arrival = client_.read(into))
            return arrival;
    return Arrival{.count = 0, .at = clock_->now()};
}

std::expected<std::uint32_t, Error> TcpListener::set_bit_rate(std::uint32_t)
{
    return fail(Errc::unsupported, "a TCP link has no bit rate");
}

} // namespace sinew::link
