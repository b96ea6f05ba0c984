#pragma once
#include "sinew/link/descriptor.hpp"
#include "sinew/link/reopen.hpp"
#include "sinew/link/uri.hpp"

#include <string>

namespace sinew::link {

/// How long `open_tcp` waits for one address of the host to answer.
inline constexpr Duration tcp_connect_limit = std::chrono::seconds{2};

/// Raw bytes to an RS-485-to-Ethernet box: `tcp://HOST:PORT`, without delay (TCP_NODELAY) and with keep-alive, so that
/// a box that lost its power is noticed within about 8 s. The box has its own serial settings: option `baud` only tells
/// the link what they are, so that time-outs can be computed; without it the rate counts as unknown (0) and
/// `set_bit_rate` is `unsupported` in any case. Option `echo=on|off|auto`: whether the box hears itself.
///
/// A host that is a name is looked up first, which takes as long as the resolver does. `link_not_found` when the host
/// is unknown, refuses, is out of reach or silent. The clock must outlive the link.
std::expected<std::unique_ptr<ByteLink>, Error> open_tcp(const Uri& uri, Clock& clock);

/// Connects again to the box of a link that was lost, without waiting: a try begins a connection and the next one looks
/// what became of it; the addresses are those that the name had when this was called. The clock must outlive it.
Reopen reopen_tcp(const Uri& uri, Clock& clock);

/// The device end: what an RS-485-to-Ethernet box is to its network. Serves one client at a time; the next one waits
/// until that one hangs up, which is no hang-up of this end.
class TcpListener final : public ByteLink
{
public:
    /// Listens on a numeric address of this machine; port 0 takes a free one. `link_busy` when the port is taken. The
    /// clock must outlive the listener.
    static std::expected<std::unique_ptr<TcpListener>, Error> open(const std::string& address, std::uint16_t port,
                                                                   const Clock& clock);

    std::uint16_t port() const { return port_; }
    bool has_client() const { return client_.is_open(); }

    /// Without a client the bytes are lost, as on a wire where nobody listens.
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override;
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override;
    /// Changes whenever a client comes or goes: ask before every wait.
    int handle() const override { return has_client() ? client_.fd() : listener_.get(); }
    LinkState state() const override { return {.open = true, .bit_rate = 0}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override;

private:
    TcpListener(Fd listener, std::uint16_t port, const Clock& clock);
    void accept();

    Fd listener_;
    std::uint16_t port_;
    const Clock* clock_;
    Descriptor client_;
};

} // namespace sinew::link
