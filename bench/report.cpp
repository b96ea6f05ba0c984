#include "bench/report.hpp"

#include <cstdio>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <string_view>

namespace sinew::bench {
namespace {

std::string json(const Result& r)
{
    return fmt::format("    {{\"family\": \"{}\", \"operation\": \"{}\", \"message\": \"{}\", \"ns\": {:.3f}, "
                       "\"reference_ns\": {:.3f}, \"reference_again_ns\": {:.3f}, \"ratio\": {:.3f}, "
                       "\"floor\": {:.3f}, \"allocations\": {}}}",
                       r.family, r.operation, r.message, r.ns, r.reference_ns, r.reference_again_ns, r.ratio(),
                       r.floor(), r.allocations);
}

std::string json(const Cost& c)
{
    return fmt::format("      {{\"name\": \"{}\", \"ns\": {:.2f}, \"again_ns\": {:.2f}, \"floor\": {:.3f}}}", c.name,
                       c.ns, c.again_ns, c.floor());
}

std::string json(const WorldResult& w)
{
    return fmt::format("      {{\"servos\": {}, \"simulated_s\": {}, \"wall_s\": {:.4f}, \"floor\": {:.3f}, "
                       "\"exchanges\": {}, \"device_seconds_per_s\": {:.1f}, \"times_real_time\": {:.3f}, "
                       "\"bytes_per_servo\": {:.0f}, \"allocations\": {}}}",
                       w.servos, w.simulated_s, w.wall_s, w.floor(), w.exchanges, w.device_seconds_per_s(),
                       w.times_real_time(), w.bytes_per_servo, w.allocations);
}

std::string json(std::string_view name, const Lateness& l)
{
    return fmt::format("\"{}\": {{\"median_us\": {:.1f}, \"p99_us\": {:.1f}, \"most_us\": {:.1f}}}", name, l.median_us,
                       l.p99_us, l.most_us);
}

template <class T>
std::string lines(const std::vector<T>& all)
{
    std::vector<std::string> out;
    for (const T& one : all)
        out.push_back(json(one));
    return fmt::format("{}", fmt::join(out, ",\n"));
}

} // namespace

void print(const std::vector<Result>& codecs)
{
    fmt::print("codec\n  {:<6} {:<7} {:<26} {:>8} {:>10} {:>6} {:>6} {:>7}\n", "family", "", "message", "ns",
               "by hand ns", "ratio", "floor", "allocs");
    for (const Result& r : codecs)
        fmt::print("  {:<6} {:<7} {:<26} {:>8.2f} {:>10.2f} {:>6.2f} {:>6.2f} {:>7g}\n", r.family, r.operation,
                   r.message, r.ns, r.reference_ns, r.ratio(), r.floor(), r.allocations);
    fmt::print("  ratio: codec / by hand; floor: by hand / by hand, measured twice; allocs: per operation\n");
}

void print(const SimResult& simulator)
{
    fmt::print("\nsimulator\n  {:<48} {:>8} {:>9} {:>6}\n", "", "ns", "again ns", "floor");
    for (const Cost& c : simulator.costs)
        fmt::print("  {:<48} {:>8.1f} {:>9.1f} {:>6.2f}\n", c.name, c.ns, c.again_ns, c.floor());
    fmt::print("\n  {:>6} {:>11} {:>8} {:>6} {:>10} {:>16} {:>12} {:>9} {:>11} {:>7}\n", "servos", "simulated s",
               "wall s", "floor", "exchanges", "device s per s", "x real time", "us each", "bytes each", "allocs");
    for (const WorldResult& w : simulator.worlds)
        fmt::print("  {:>6} {:>11.1f} {:>8.2f} {:>6} {:>10} {:>16.0f} {:>12.2f} {:>9.1f} {:>11.0f} {:>7g}\n", w.servos,
                   w.simulated_s, w.wall_s, w.wall_again_s > 0.0 ? fmt::format("{:.2f}", w.floor()) : "-", w.exchanges,
                   w.device_seconds_per_s(), w.times_real_time(), 1e6 / w.device_seconds_per_s(), w.bytes_per_servo,
                   w.allocations);
    fmt::print("  floor: the same measured again / the first; us each: wall time of a simulated second of one servo,\n"
               "  the same once buses are full, when growth is linear; bytes each: with wires, whose buffers few "
               "servos share\n");
}

void print(const LatenessResult& l)
{
    fmt::print("\nreal time: {} actuators behind pseudo terminals, {} answers ({} missing, {} held up by 10 ms)\n",
               l.actuators, l.answers, l.missing, l.held_up);
    fmt::print("  {:<48} {:>10} {:>8} {:>8}\n", "late by", "median us", "p99 us", "most us");
    const auto row = [](std::string_view name, const Lateness& late) {
        fmt::print("  {:<48} {:>10.1f} {:>8.1f} {:>8.1f}\n", name, late.median_us, late.p99_us, late.most_us);
    };
    row("an answer, after bits and response time", l.answer);
    row("a thread that waits for as long", l.timer);
    row("the same again", l.timer_again);
    fmt::print("  ratio {:.2f} of the medians, answer / timer; floor {:.2f}, timer / timer\n", l.ratio(), l.floor());
}

void print(const RecordResult& r)
{
    fmt::print("\nrecording: 16 joints at 1 kHz for {:g} min, {} messages, {} lost\n", r.simulated_min, r.messages,
               r.dropped);
    fmt::print("  {:.3f} CPU s for a minute of data ({:.3f} to push, {:.3f} to format and write): {:.2f} % of a core\n",
               r.push_s_per_min + r.write_s_per_min, r.push_s_per_min, r.write_s_per_min, 100.0 * r.share);
    fmt::print("  {:.0f} ns a push, with {:g} requests to the heap in all; {:.1f} MB a minute\n", r.push_ns,
               r.allocations, 1e-6 * r.bytes_per_min);
}

bool write_json(const std::string& path, const Report& report)
{
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr)
        return false;
    fmt::print(file, "{{\n  \"codec\": [\n{}\n  ]", lines(report.codecs));
    if (report.simulator)
        fmt::print(file, ",\n  \"simulator\": {{\n    \"costs\": [\n{}\n    ],\n    \"worlds\": [\n{}\n    ]\n  }}",
                   lines(report.simulator->costs), lines(report.simulator->worlds));
    if (report.lateness) {
        const LatenessResult& l = *report.lateness;
        fmt::print(file,
                   ",\n  \"real_time\": {{\"actuators\": {}, \"answers\": {}, \"missing\": {}, \"held_up\": {}, {}, "
                   "{}, {}, \"ratio\": {:.3f}, \"floor\": {:.3f}}}",
                   l.actuators, l.answers, l.missing, l.held_up, json("answer", l.answer), json("timer", l.timer),
                   json("timer_again", l.timer_again), l.ratio(), l.floor());
    }
    if (report.recording) {
        const RecordResult& r = *report.recording;
        fmt::print(file,
                   ",\n  \"recording\": {{\"simulated_min\": {}, \"push_s_per_min\": {:.4f}, \"write_s_per_min\": "
                   "{:.4f}, \"share\": {:.5f}, \"push_ns\": {:.1f}, \"bytes_per_min\": {:.0f}, \"messages\": {}, "
                   "\"dropped\": {}, \"allocations\": {}}}",
                   r.simulated_min, r.push_s_per_min, r.write_s_per_min, r.share, r.push_ns, r.bytes_per_min,
                   r.messages, r.dropped, r.allocations);
    }
    fmt::print(file, "\n}}\n");
    return std::fclose(file) == 0;
}

} // namespace sinew::bench
