#include "sinew/bus/bus.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/lines.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/lines.hpp"
#include "sinew/family/sam/framing.hpp"
#include "sinew/family/sam/messages.hpp"
#include "sinew/link/serial.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/peer.hpp"

#include <fmt/core.h>

/// transactions FAMILY COUNT: so many typed calls to a device on a real descriptor, between two calls of getppid().
/// What happens between them is counted from outside: system calls by strace, instructions by callgrind. Prints how
/// often the heap was asked.
namespace {

using namespace sinew;

/// Not inlined, so that callgrind can be told to look at it alone.
template <class M>
[[gnu::noinline]] bool counted_transactions(bus::Bus& bus, int id, int count)
{
    bool good = true;
    for (int i = 0; i < count; ++i)
        good = bus.call(id, M{}).has_value() && good;
    return good;
}

template <class M>
int run(link::AnyLink link, link::Clock& clock, const wire::Protocol& protocol, const wire::Profile& line, int id,
        int count)
{
    // What others keep from running for a while is no time-out.
    constexpr Duration patience = std::chrono::milliseconds(900);
    bus::Bus bus("counted", std::move(link), clock, protocol,
                 {.margin_at_first = patience, .margin_least = patience, .margin_most = patience});
    bus.set_device(id, {.line = &line});
    for (int i = 0; i < 100; ++i)
        if (!bus.call(id, M{}))
            return 1;
    const auto before = support::allocations();
    (void)::getppid();
    const bool good = counted_transactions<M>(bus, id, count);
    (void)::getppid();
    fmt::print("allocations {}\n", support::allocations() - before);
    return good ? 0 : 1;
}

template <class M>
int run_on_pty(const wire::Protocol& protocol, const wire::Profile& line, const wire::ReplyOf<M>& reply, int count)
{
    constexpr int id = 5;
    constexpr std::uint32_t bit_rate = 1'000'000;
    link::RealClock clock;
    const auto answer = *wire::encode_reply<M>(id, reply);
    const auto at_least = bus::predict({.bit_rate = bit_rate}, *wire::make_request(id, M{})).total();
    const auto peer = support::Peer::on_pty(wire::info_of<M>.request.size, answer.bytes(), at_least);
    auto link = link::open_serial({.device = peer.device, .bit_rate = bit_rate}, clock);
    if (!link)
        return 1;
    return run<M>(std::move(*link), clock, protocol, line, id, count);
}

} // namespace

int main(int argc, char** argv)
{
    const std::string_view family = argc > 2 ? argv[1] : "";
    const int count = argc > 2 ? std::atoi(argv[2]) : 0;
    static constexpr wire::Profile sam_line{.name = "sam", .messages = sam::manual_messages};
    static constexpr wire::Profile nuri_line{.name = "nuri", .messages = nuri::manual_messages};
    static constexpr wire::Profile rmd_line{.name = "rmd", .messages = rmd::manual_messages};
    if (family == "sam")
        return run_on_pty<sam::QuickReadStatus>(sam::protocol(), sam_line, {.load = 1, .position = 2}, count);
    if (family == "nuri")
        return run_on_pty<nuri::RequestPositionFeedback>(nuri::protocol(), nuri_line, {.position = 4711}, count);
    if (family == "rmd") {
        link::RealClock clock;
        const auto peer = support::Peer::on_socket();
        std::unique_ptr<link::CanLink> link = std::make_unique<support::SocketFrames>(peer.fd, clock);
        return run<rmd::ReadStatus2>(std::move(link), clock, rmd::protocol(), rmd_line, 5, count);
    }
    fmt::print(stderr, "usage: transactions sam|nuri|rmd COUNT\n");
    return 2;
}
