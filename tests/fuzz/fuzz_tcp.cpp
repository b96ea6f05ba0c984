#include "sinew/link/echo.hpp"
#include "sinew/link/tcp.hpp"
#include "tests/fuzz/check.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <vector>

using namespace sinew;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// The real clock, which a step of the input puts forward.
class Clock final : public link::Clock
{
public:
    TimePoint now() const override { return real_.now() + ahead; }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        real_.wait(handles, deadline - ahead);
    }
    Duration ahead{};

private:
    link::RealClock real_;
};

/// Lends the connection to an echo filter of one input: connections for every input would use up the ports.
class Lent final : public link::ByteLink
{
public:
    explicit Lent(link::ByteLink& link) : link_(&link) {}
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> b) override { return link_->write(b); }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        const auto arrival = link_->read(into);
        came += arrival ? arrival->count : 0;
        return arrival;
    }
    int handle() const override { return link_->handle(); }
    link::LinkState state() const override { return link_->state(); }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t rate) override { return link_->set_bit_rate(rate); }

    std::size_t came = 0;

private:
    link::ByteLink* link_;
};

struct Ends {
    Clock clock;
    std::unique_ptr<link::TcpListener> box = std::move(*link::TcpListener::open("127.0.0.1", 0, clock));
    std::unique_ptr<link::ByteLink> link;

    void connect()
    {
        const auto uri = *link::parse_uri(fmt::format("tcp://127.0.0.1:{}?baud=115200", box->port()));
        auto opened = link::open_tcp(uri, clock);
        SINEW_CLAIM(opened.has_value());
        link = std::move(*opened);
        while (!box->has_client())
            (void)box->read({});
    }
};

/// Reads until that many have come; loopback has them at once.
void read_until(link::ByteLink& end, link::Clock& clock, Bytes& got, std::size_t wanted)
{
    const TimePoint deadline = clock.now() + std::chrono::seconds(5);
    std::array<std::uint8_t, 512> into;
    while (got.size() < wanted && clock.now() < deadline) {
        const auto arrival = end.read(into);
        SINEW_CLAIM(arrival.has_value());
        got.insert(got.end(), into.begin(), into.begin() + static_cast<std::ptrdiff_t>(arrival->count));
        const link::Handle handles[] = {{.fd = end.handle()}};
        if (arrival->count == 0)
            clock.wait(handles, deadline);
    }
    SINEW_CLAIM(got.size() == wanted);
}

bool is_part_of(const Bytes& part, const Bytes& whole)
{
    auto at = whole.begin();
    for (const auto byte : part) {
        at = std::find(at, whole.end(), byte);
        if (at++ == whole.end())
            return false;
    }
    return true;
}

} // namespace

/// Any bytes in any pieces both ways through a TCP link, with and without echo. The first byte chooses; then a byte
/// tells who does what with how many of the bytes that follow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    static Ends ends;
    if (size == 0 || size > 4096)
        return 0;
    if (!ends.link)
        ends.connect();
    const auto echo = static_cast<link::Echo>(data[0] % 3);
    auto lent = std::make_unique<Lent>(*ends.link);
    const std::size_t& came = lent->came;
    const auto link = link::with_echo(std::move(lent), echo, ends.clock);
    Bytes sent, told, got, heard;
    const auto read_some = [&](std::size_t most) {
        std::array<std::uint8_t, 64> into;
        const auto arrival = link->read(std::span(into).first(std::min(most, into.size())));
        SINEW_CLAIM(arrival.has_value() && arrival->count <= most);
        got.insert(got.end(), into.begin(), into.begin() + static_cast<std::ptrdiff_t>(arrival->count));
        return arrival->count;
    };
    for (std::span rest(data + 1, size - 1); !rest.empty();) {
        const std::size_t count = rest[0] >> 2;
        const auto piece = rest.subspan(1, std::min(count, rest.size() - 1));
        switch (rest[0] & 3) {
        case 0: // the box speaks
            SINEW_CLAIM(ends.box->write(piece).value() == piece.size());
            told.insert(told.end(), piece.begin(), piece.end());
            rest = rest.subspan(1 + piece.size());
            break;
        case 1: { // the link speaks
            const auto written = link->write(piece);
            SINEW_CLAIM(written.has_value() && *written <= piece.size());
            sent.insert(sent.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(*written));
            rest = rest.subspan(1 + piece.size());
            break;
        }
        case 2:
            read_some(count);
            rest = rest.subspan(1);
            break;
        default:
            ends.clock.ahead += std::chrono::milliseconds(count);
            rest = rest.subspan(1);
        }
    }
    read_until(*ends.box, ends.clock, heard, sent.size());
    SINEW_CLAIM(heard == sent);
    // Loopback brings everything; the next input begins with an empty line.
    const TimePoint deadline = ends.clock.now() + std::chrono::seconds(5);
    const link::Handle handles[] = {{.fd = link->handle()}};
    for (int empty = 0; empty < 2 && ends.clock.now() < deadline;) {
        if (read_some(64) > 0)
            empty = 0;
        else if (came == told.size())
            ++empty;
        else
            ends.clock.wait(handles, deadline);
    }
    SINEW_CLAIM(came == told.size());
    // An echo filter may keep bytes back, but makes none up and changes no order.
    SINEW_CLAIM(echo == link::Echo::off ? got == told : is_part_of(got, told));
    SINEW_CLAIM(link->state().open);
    return 0;
}
