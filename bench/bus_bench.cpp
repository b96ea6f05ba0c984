#include "bench/loop_bench.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/bus/real_time.hpp"
#include "sinew/family/nuri/framing.hpp"
#include "sinew/family/nuri/messages.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/link/serial.hpp"
#include "tests/support/peer.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <functional>
#include <sched.h>
#include <thread>
#include <vector>

/// bus_bench [ROUNDS] [--loop SECONDS]: what the bus adds to the bare ping-pong of the same bytes (write, ppoll, read)
/// on a pseudo terminal, and what a cycle of many motors costs over a socket that stands in for CAN, beside the bare
/// sendmmsg, ppoll and recvmmsg of the same frames. Each round measures all of it, the floor twice; printed are medians
/// over the rounds with the spread, as ratios to the floor of the same round. Then the loop of `loop_bench.hpp`.
///
/// The device process of the socket takes all frames that are there with one recvmmsg and answers them with one
/// sendmmsg, so that it costs a cycle no more than it must: what is measured is the host. A packet is a frame, as on a
/// CAN socket, and the kernel copies each of them four times. Measured with the device on another processor, where an
/// exchange of one frame is two wake-ups across processors as behind real hardware, and on the same one, where there is
/// nothing but the copying and it is done one after the other.
namespace {

using namespace sinew;
using namespace std::chrono_literals;

double now_s(clockid_t clock)
{
    timespec t{};
    ::clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Run {
    double per_s = 0.0;
    double cpu_us = 0.0;
    double p50_us = 0.0;
    double p99_us = 0.0;
};

Run measure(int count, const std::function<void()>& transaction)
{
    std::vector<double> took;
    took.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count / 10; ++i)
        transaction();
    const double cpu = now_s(CLOCK_PROCESS_CPUTIME_ID);
    const double start = now_s(CLOCK_MONOTONIC);
    for (double before = start; took.size() < static_cast<std::size_t>(count);) {
        transaction();
        const double after = now_s(CLOCK_MONOTONIC);
        took.push_back(1e6 * (after - before));
        before = after;
    }
    Run run{.per_s = count / (now_s(CLOCK_MONOTONIC) - start),
            .cpu_us = 1e6 * (now_s(CLOCK_PROCESS_CPUTIME_ID) - cpu) / count};
    std::ranges::sort(took);
    run.p50_us = took[took.size() / 2];
    run.p99_us = took[took.size() * 99 / 100];
    return run;
}

void fail_with(std::string_view what)
{
    fmt::print(stderr, "bus_bench: {}\n", what);
    std::exit(1);
}

/// The bare ping-pong on the same device.
void ping_pong(int fd, std::span<const std::uint8_t> request, std::size_t reply_size)
{
    std::array<std::uint8_t, 64> heard;
    if (::write(fd, request.data(), request.size()) < 0)
        fail_with("the pseudo terminal takes nothing");
    for (std::size_t count = 0; count < reply_size;) {
        pollfd polled{.fd = fd, .events = POLLIN, .revents = 0};
        const timespec limit{.tv_sec = 1, .tv_nsec = 0};
        ::ppoll(&polled, 1, &limit, nullptr);
        const ssize_t got = ::read(fd, heard.data(), heard.size());
        if (got > 0)
            count += static_cast<std::size_t>(got);
    }
}

struct Ratio {
    std::vector<double> rate, cpu, p99;
    void add(const Run& run, const Run& floor)
    {
        rate.push_back(run.per_s / floor.per_s);
        cpu.push_back(run.cpu_us / floor.cpu_us);
        p99.push_back(run.p99_us / floor.p99_us);
    }
    static std::string spread(std::vector<double>& all)
    {
        std::ranges::sort(all);
        return fmt::format("{:.2f} ({:.2f}-{:.2f})", all[all.size() / 2], all.front(), all.back());
    }
    void print(std::string_view name)
    {
        fmt::print("  {:<34} {:>18} {:>18} {:>18}\n", name, spread(rate), spread(cpu), spread(p99));
    }
};

void serial(int rounds, Duration after)
{
    constexpr int id = 5;
    const int count = after > Duration{} ? 500 : 2000;
    const auto request = *wire::encode_request(id, nuri::RequestPositionFeedback{});
    const auto reply = *wire::encode_reply<nuri::RequestPositionFeedback>(id, {.position = 4711});
    const auto peer = support::Peer::on_pty(request.size, reply.bytes(), after);
    link::RealClock clock;
    auto link = link::open_serial({.device = peer.device, .bit_rate = 1'000'000}, clock);
    if (!link)
        fail_with(to_sentence(link.error()));
    const int fd = (*link)->handle();
    bus::Bus bus("bench", link::AnyLink{std::move(*link)}, clock, nuri::protocol(), {.paced = false});
    Ratio of_bus;
    Ratio of_floor;
    for (int i = 0; i < rounds; ++i) {
        const Run floor = measure(count, [&] { ping_pong(fd, request.bytes(), reply.size); });
        const Run ours = measure(count, [&] {
            if (!bus.call(id, nuri::RequestPositionFeedback{}))
                fail_with("no answer");
        });
        const Run again = measure(count, [&] { ping_pong(fd, request.bytes(), reply.size); });
        of_bus.add(ours, floor);
        of_floor.add(again, floor);
    }
    fmt::print("pty, device answers after {} µs        {:>18} {:>18} {:>18}\n", after.count() / 1000, "rate",
               "client CPU", "p99");
    of_bus.print("bus.call / floor");
    of_floor.print("floor again / floor");
}

/// So many frames out with one call and back with as few as it takes, and nothing else.
class BareCycle
{
public:
    explicit BareCycle(int fd) : fd_(fd)
    {
        for (std::size_t i = 0; i < frames_.size(); ++i) {
            frames_[i].can_id = static_cast<canid_t>(0x141 + i);
            frames_[i].len = 8;
            places_[i] = {&frames_[i], sizeof frames_[i]};
            messages_[i].msg_hdr.msg_iov = &places_[i];
            messages_[i].msg_hdr.msg_iovlen = 1;
        }
    }
    void run(std::size_t size)
    {
        if (::sendmmsg(fd_, messages_.data(), static_cast<unsigned>(size), MSG_NOSIGNAL) < 0)
            fail_with("the socket takes nothing");
        for (std::size_t count = 0; count < size;) {
            pollfd polled{.fd = fd_, .events = POLLIN, .revents = 0};
            const timespec limit{.tv_sec = 1, .tv_nsec = 0};
            ::ppoll(&polled, 1, &limit, nullptr);
            const int got =
                ::recvmmsg(fd_, messages_.data(), static_cast<unsigned>(messages_.size()), MSG_DONTWAIT, nullptr);
            count += got > 0 ? static_cast<std::size_t>(got) : 0;
        }
    }

private:
    int fd_;
    std::array<can_frame, 64> frames_{};
    std::array<iovec, 64> places_{};
    std::array<mmsghdr, 64> messages_{};
};

/// The processors that this program may use.
std::vector<int> processors()
{
    cpu_set_t allowed;
    std::vector<int> out;
    if (::sched_getaffinity(0, sizeof allowed, &allowed) == 0)
        for (int i = 0; i < CPU_SETSIZE; ++i)
            if (CPU_ISSET(i, &allowed))
                out.push_back(i);
    return out;
}

/// In a thread of its own, for it keeps to the processor `host`.
void cycles(int rounds, int host, int device)
{
    const auto peer = support::Peer::on_socket();
    const auto bare_peer = support::Peer::on_socket();
    peer.bind_to(device);
    bare_peer.bind_to(device);
    for (const auto& refused : bus::apply({.processor = host}))
        fail_with(refused.reason);
    BareCycle bare(bare_peer.fd);
    link::RealClock clock;
    std::unique_ptr<link::CanLink> link = std::make_unique<support::SocketFrames>(peer.fd, clock);
    bus::Bus bus("bench", link::AnyLink{std::move(link)}, clock, rmd::protocol());
    std::vector<wire::Request> requests;
    for (int id = 1; id <= 32; ++id)
        requests.push_back(*wire::make_request(id, rmd::ReadStatus2{}));
    std::vector<bus::Result> results(requests.size());
    const auto cycle = [&](std::size_t size) {
        return measure(1000,
                       [&, size] {
                           (void)bus.exchange(std::span(requests).first(size), std::span(results).first(size));
                           for (std::size_t i = 0; i < size; ++i)
                               if (!results[i].good)
                                   fail_with("no answer");
                       })
            .p50_us;
    };
    const auto bare_cycle = [&](std::size_t size) { return measure(1000, [&, size] { bare.run(size); }).p50_us; };
    constexpr std::array<std::size_t, 3> sizes{1, 12, 32};
    std::array<std::vector<double>, 3> us, to_one, bare_to_one, to_bare, bare_to_bare;
    for (int i = 0; i < rounds; ++i) {
        std::array<double, 3> ours{}, floor{};
        for (std::size_t k = 0; k < sizes.size(); ++k) {
            floor[k] = bare_cycle(sizes[k]);
            ours[k] = cycle(sizes[k]);
            bare_to_bare[k].push_back(bare_cycle(sizes[k]) / floor[k]);
            us[k].push_back(ours[k]);
            to_one[k].push_back(ours[k] / ours[0]);
            bare_to_one[k].push_back(floor[k] / floor[0]);
            to_bare[k].push_back(ours[k] / floor[k]);
        }
    }
    fmt::print("socket, the device on {} processor\n", host == device ? "the same" : "another");
    fmt::print("a cycle (p50)                 {:>20} {:>18} {:>18} {:>18} {:>18}\n", "us", "/ one", "bare: / one",
               "bus / bare", "floor again");
    for (std::size_t k = 0; k < sizes.size(); ++k)
        fmt::print("  {:>2} motors                   {:>20} {:>18} {:>18} {:>18} {:>18}\n", sizes[k],
                   Ratio::spread(us[k]), Ratio::spread(to_one[k]), Ratio::spread(bare_to_one[k]),
                   Ratio::spread(to_bare[k]), Ratio::spread(bare_to_bare[k]));
}

} // namespace

int main(int argc, char** argv)
{
    int rounds = 15;
    int loop_seconds = 6;
    for (int i = 1; i < argc; ++i)
        if (std::string_view(argv[i]) == "--loop" && i + 1 < argc)
            loop_seconds = std::max(0, std::atoi(argv[++i]));
        else
            rounds = std::max(1, std::atoi(argv[i]));
    fmt::print("\nbus, {} rounds: median (least-most)\n", rounds);
    serial(rounds, Duration{});
    serial(rounds, 250us);
    const auto where = processors();
    if (where.size() > 1)
        std::thread(cycles, rounds, where[0], where[1]).join();
    std::thread(cycles, rounds, where.at(0), where.at(0)).join();
    if (loop_seconds > 0)
        bench::print(bench::measure_loop(std::chrono::seconds(loop_seconds)));
    return 0;
}
