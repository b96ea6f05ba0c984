#include "bench/loop_bench.hpp"

#include "sinew/bus/bus.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "tests/support/peer.hpp"

#include <algorithm>
#include <fmt/core.h>
#include <functional>
#include <memory>

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

constexpr Duration period = 1ms;
constexpr int buses = 4;
constexpr int actuators = 8;

/// One bus, the device process behind it, and the questions of a cycle.
class Limb
{
public:
    explicit Limb(link::Clock& clock)
        : peer_(support::Peer::on_socket()),
          bus("limb",
              link::AnyLink{std::unique_ptr<link::CanLink>(std::make_unique<support::SocketFrames>(peer_.fd, clock))},
              clock, rmd::protocol())
    {
        for (int id = 1; id <= actuators; ++id)
            requests_.push_back(*wire::make_request(id, rmd::ReadStatus2{}));
        results_.resize(requests_.size());
    }
    void start() { bus.start(requests_, results_); }
    std::size_t missing() const
    {
        return static_cast<std::size_t>(std::ranges::count(results_, false, &bus::Result::good));
    }

private:
    support::Peer peer_;
    std::vector<wire::Request> requests_;
    std::vector<bus::Result> results_;

public:
    bus::Bus bus;
};

double us(Duration d)
{
    return 1e6 * seconds(d);
}

/// A second of cycles; a cycle that is over too late moves those that follow.
void run(LoopRun& into, link::Clock& clock, const std::function<void()>& cycle)
{
    TimePoint due = clock.now() + period;
    for (const TimePoint end = clock.now() + 1s; due < end; due += period) {
        while (clock.now() < due)
            clock.wait({}, due);
        const TimePoint begun = clock.now();
        cycle();
        const TimePoint done = clock.now();
        into.late_us.push_back(us(begun - due));
        into.took_us.push_back(us(done - begun));
        if (done > due + period) {
            ++into.overruns;
            due = done;
        }
    }
}

double at(const std::vector<double>& sorted, double part)
{
    return sorted.empty() ? 0.0 : sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

void print(std::string_view name, const LoopRun& run)
{
    fmt::print("  {:<38} {:>7} {:>9} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f}\n", name, run.late_us.size(),
               run.overruns, at(run.late_us, 0.5), at(run.late_us, 0.99), at(run.late_us, 0.999), at(run.late_us, 1.0),
               at(run.took_us, 0.5), at(run.took_us, 0.99));
}

} // namespace

LoopResult measure_loop(std::chrono::seconds time)
{
    link::RealClock clock;
    std::vector<std::unique_ptr<Limb>> limbs;
    std::vector<bus::Bus*> all;
    for (int i = 0; i < buses; ++i) {
        limbs.push_back(std::make_unique<Limb>(clock));
        all.push_back(&limbs.back()->bus);
    }
    LoopResult out;
    const auto ask_all = [&] {
        for (auto& limb : limbs)
            limb->start();
        bus::drive(all);
        for (auto& limb : limbs)
            out.missing += limb->missing();
    };
    const auto nothing = [] {};
    for (const TimePoint end = clock.now() + 3 * time; clock.now() < end;) {
        run(out.timer, clock, nothing);
        run(out.buses, clock, ask_all);
        run(out.timer_again, clock, nothing);
    }
    for (LoopRun* one : {&out.buses, &out.timer, &out.timer_again}) {
        std::ranges::sort(one->late_us);
        std::ranges::sort(one->took_us);
    }
    return out;
}

void print(const LoopResult& loop)
{
    fmt::print("\nloop of 1 ms, {} buses with {} actuators each, {} answers missing\n", buses, actuators, loop.missing);
    fmt::print("  {:<38} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "in us", "cycles", "overruns", "late p50",
               "p99", "p99.9", "most", "took p50", "p99");
    print("all buses, every actuator asked", loop.buses);
    print("a timer alone", loop.timer);
    print("the same again", loop.timer_again);
    fmt::print("  late p99: buses / timer {:.2f}, floor (timer / timer) {:.2f}\n",
               at(loop.buses.late_us, 0.99) / at(loop.timer.late_us, 0.99),
               at(loop.timer_again.late_us, 0.99) / at(loop.timer.late_us, 0.99));
}

} // namespace sinew::bench
