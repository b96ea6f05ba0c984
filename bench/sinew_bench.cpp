#include "bench/report.hpp"

#include <cstdio>
#include <fmt/core.h>
#include <string_view>

namespace {

constexpr std::size_t answers_in_real_time = 2000;
constexpr double recorded_minutes = 10.0;

constexpr std::string_view usage =
    "usage: sinew_bench [--json FILE] [--robot FILE] [--hour] [codec] [simulator] [record]\n"
    "Parts to measure; without any of them: all. Real time needs --robot.\n";

struct Arguments {
    std::string json;
    std::string robot;
    bool hour = false;
    bool codec = false;
    bool simulator = false;
    bool record = false;
    bool is_right = true;
};

Arguments read(int argc, char** argv)
{
    Arguments out;
    for (int i = 1; i < argc; ++i) {
        const std::string_view word = argv[i];
        const bool has_value = i + 1 < argc;
        if (word == "--json" && has_value)
            out.json = argv[++i];
        else if (word == "--robot" && has_value)
            out.robot = argv[++i];
        else if (word == "--hour")
            out.hour = true;
        else if (word == "codec")
            out.codec = true;
        else if (word == "simulator")
            out.simulator = true;
        else if (word == "record")
            out.record = true;
        else
            out.is_right = false;
    }
    if (!out.codec && !out.simulator && !out.record && out.robot.empty())
        out.codec = out.simulator = out.record = true;
    return out;
}

} // namespace

/// Exit 0, 1: the codec allocates, 2: wrong use, or a file cannot be read or written.
int main(int argc, char** argv)
{
    using namespace sinew::bench;
    const Arguments arguments = read(argc, argv);
    if (!arguments.is_right) {
        fmt::print(stderr, "{}", usage);
        return 2;
    }
    Report report;
    if (arguments.codec) {
        report.codecs = measure_codecs();
        print(report.codecs);
    }
    if (arguments.simulator) {
        report.simulator = measure_simulator(arguments.hour);
        print(*report.simulator);
    }
    if (arguments.record) {
        auto recording = measure_recording(recorded_minutes);
        if (!recording) {
            fmt::print(stderr, "sinew_bench: {}\n", sinew::to_sentence(recording.error()));
            return 2;
        }
        report.recording = *recording;
        print(*report.recording);
    }
    if (!arguments.robot.empty()) {
        auto lateness = measure_lateness(arguments.robot, answers_in_real_time);
        if (!lateness) {
            fmt::print(stderr, "sinew_bench: {}\n", sinew::to_sentence(lateness.error()));
            return 2;
        }
        report.lateness = *lateness;
        print(*report.lateness);
    }
    if (!arguments.json.empty() && !write_json(arguments.json, report)) {
        fmt::print(stderr, "sinew_bench: cannot write {}\n", arguments.json);
        return 2;
    }
    for (const Result& r : report.codecs)
        if (r.allocations != 0.0) {
            fmt::print(stderr, "sinew_bench: {} {} asks the heap for memory\n", r.family, r.operation);
            return 1;
        }
    return 0;
}
