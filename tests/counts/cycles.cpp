#include "sinew/bus/bus.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/peer.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <vector>

/// cycles MOTORS COUNT: so many exchanges with as many RMD motors on a socket that stands in for CAN, counted as those
/// of `transactions.cpp` are; a program of its own, for what the compiler makes of those depends on what stands beside
/// them.
namespace {

using namespace sinew;

bool cycle(bus::Bus& bus, std::span<const wire::Request> requests, std::span<bus::Result> results)
{
    return bus.exchange(requests, results).has_value() && std::ranges::all_of(results, &bus::Result::good);
}

[[gnu::noinline]] bool counted_transactions(bus::Bus& bus, std::span<const wire::Request> requests,
                                            std::span<bus::Result> results, int count)
{
    bool good = true;
    for (int i = 0; i < count; ++i)
        good = cycle(bus, requests, results) && good;
    return good;
}

/// This program and the device take turns on one processor, so that each finds all frames of the other in one piece.
int run(int motors, int count)
{
    constexpr Duration patience = std::chrono::milliseconds(900);
    link::RealClock clock;
    const auto peer = support::Peer::on_socket();
    peer.take_turns();
    bus::Bus bus("counted", std::unique_ptr<link::CanLink>(new support::SocketFrames(peer.fd, clock)), clock,
                 rmd::protocol(), {.margin_at_first = patience, .margin_least = patience, .margin_most = patience});
    std::vector<wire::Request> requests;
    for (int id = 1; id <= motors; ++id)
        requests.push_back(*wire::make_request(id, rmd::ReadStatus2{}));
    std::vector<bus::Result> results(requests.size());
    for (int i = 0; i < 100; ++i)
        if (!cycle(bus, requests, results))
            return 1;
    const auto before = support::allocations();
    (void)::getppid();
    const bool good = counted_transactions(bus, requests, results, count);
    (void)::getppid();
    fmt::print("allocations {}\n", support::allocations() - before);
    return good ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    if (argc == 3)
        return run(std::atoi(argv[1]), std::atoi(argv[2]));
    fmt::print(stderr, "usage: cycles MOTORS COUNT\n");
    return 2;
}
