#include "bench/codec_bench.hpp"
#include "bench/sim_bench.hpp"

#include <cstdio>
#include <fmt/core.h>
#include <string_view>

namespace {

using sinew::bench::Result;

void print(const std::vector<Result>& results)
{
    fmt::print("{:<6} {:<7} {:<26} {:>8} {:>10} {:>6} {:>6} {:>7}\n", "family", "", "message", "ns", "by hand ns",
               "ratio", "floor", "allocs");
    for (const auto& r : results)
        fmt::print("{:<6} {:<7} {:<26} {:>8.2f} {:>10.2f} {:>6.2f} {:>6.2f} {:>7g}\n", r.family, r.operation, r.message,
                   r.ns, r.reference_ns, r.ratio(), r.floor(), r.allocations);
    fmt::print(
        "ratio: codec / by hand; floor: by hand / by hand, measured twice; allocs: per operation of the codec\n");
}

void print(const sinew::bench::SimResult& sim)
{
    fmt::print("\nsimulator\n");
    fmt::print("  {:<44} {:>8.1f} ns  (again {:.1f})\n", "physics, a step of a shaft that turns", sim.step_ns,
               sim.step_again_ns);
    fmt::print("  {:<44} {:>8.1f} ns\n", "physics, a tick (10 steps) of one that rests", sim.resting_tick_ns);
    fmt::print("  {:<44} {:>8.1f} ns  (again {:.1f})\n", "firmware and wire, an exchange, 31 on the wire",
               sim.exchange_ns, sim.exchange_again_ns);
    fmt::print("  {:>6} {:>11} {:>8} {:>10} {:>16} {:>12} {:>11} {:>7}\n", "servos", "simulated s", "wall s",
               "exchanges", "device s per s", "x real time", "bytes each", "allocs");
    for (const auto& w : sim.worlds)
        fmt::print("  {:>6} {:>11.1f} {:>8.2f} {:>10} {:>16.0f} {:>12.2f} {:>11.0f} {:>7g}\n", w.servos, w.simulated_s,
                   w.wall_s, w.exchanges, w.device_seconds_per_s(), w.times_real_time(), w.bytes_per_servo,
                   w.allocations);
}

bool write_json(const char* path, const std::vector<Result>& results)
{
    std::FILE* file = std::fopen(path, "w");
    if (file == nullptr)
        return false;
    fmt::print(file, "[\n");
    for (std::size_t i = 0; i < results.size(); ++i) {
        const Result& r = results[i];
        fmt::print(file,
                   "  {{\"family\": \"{}\", \"operation\": \"{}\", \"message\": \"{}\", \"ns\": {:.3f}, "
                   "\"reference_ns\": {:.3f}, \"reference_again_ns\": {:.3f}, \"ratio\": {:.3f}, \"floor\": {:.3f}, "
                   "\"allocations\": {}}}{}\n",
                   r.family, r.operation, r.message, r.ns, r.reference_ns, r.reference_again_ns, r.ratio(), r.floor(),
                   r.allocations, i + 1 < results.size() ? "," : "");
    }
    fmt::print(file, "]\n");
    return std::fclose(file) == 0;
}

} // namespace

/// sinew_bench [--json FILE]. Exit 0, 1: the codec allocates, 2: wrong use or the file cannot be written.
int main(int argc, char** argv)
{
    const bool wants_json = argc == 3 && std::string_view(argv[1]) == "--json";
    if (argc != 1 && !wants_json) {
        fmt::print(stderr, "usage: sinew_bench [--json FILE]\n");
        return 2;
    }
    const auto results = sinew::bench::measure_codecs();
    print(results);
    const auto sim = sinew::bench::measure_simulator(wants_json);
    print(sim);
    if (wants_json && !write_json(argv[2], results)) {
        fmt::print(stderr, "sinew_bench: cannot write {}\n", argv[2]);
        return 2;
    }
    for (const auto& r : results)
        if (r.allocations != 0.0) {
            fmt::print(stderr, "sinew_bench: {} {} asks the heap for memory\n", r.family, r.operation);
            return 1;
        }
    return 0;
}
