#include "sinew/bus/bus.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/sim/links.hpp"
#include <array>
#include <cstdio>

using namespace sinew;

// Six motors on one CAN bus in one exchange: all requests go out back to back, answers come in any order.
int main()
{
    sim::Worlds worlds;
    link::RealClock clock;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    auto opened = sim::open(links, clock, "sim:robots/demo.toml#legs", worlds); // or "can:can0"
    if (!opened)
        return std::puts(to_sentence(opened.error()).c_str()), 1;
    bus::Bus bus("legs", std::move(opened->link), *opened->clock, rmd::protocol());

    std::array<wire::Request, 6> requests;
    std::array<bus::Result, 6> results;
    for (int id = 1; id <= 6; ++id)
        requests[static_cast<std::size_t>(id - 1)] = *bus.request(id, rmd::ReadStatus2{});
    const auto begin = bus.clock().now();
    if (const auto done = bus.exchange(requests, results); !done)
        return std::puts(to_sentence(done.error()).c_str()), 1;
    const double took_ms = 1e3 * seconds(bus.clock().now() - begin);
    int answered = 0;
    for (std::size_t i = 0; i < results.size(); ++i)
        if (const auto reply = results[i].reply(); reply && ++answered)
            if (const auto status = wire::decode_reply<rmd::ReadStatus2>(*reply, requests[i].options))
                std::printf("motor %zu: encoder %d\n", i + 1, static_cast<int>(status->message.encoder));
    std::printf("%d motors in %.2f ms\n", answered, took_ms);
    return answered == 6 ? 0 : 1;
}
