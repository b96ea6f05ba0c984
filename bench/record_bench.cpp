#include "bench/record_bench.hpp"

#include "sinew/record/recorder.hpp"
#include "tests/support/allocations.hpp"

#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>

namespace sinew::bench {
namespace {

constexpr std::size_t joints = 16;
constexpr double cycles_per_minute = 60'000.0;
constexpr Duration cycle = std::chrono::milliseconds(1);
constexpr int cycles_per_drain = 50; // as often as the recorder's own thread does it in real time

double processor_s()
{
    timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// What a cycle of the robot leaves, with digits as they come from devices.
class Robot
{
public:
    Robot(record::Recorder& recorder, record::Recorder::Bus bus, std::array<record::Recorder::Joint, joints> names)
        : recorder_(recorder), bus_(bus), joints_(names)
    {
    }

    void run(TimePoint now)
    {
        const double t = seconds(now.time_since_epoch());
        for (std::size_t i = 0; i < joints; ++i) {
            const auto raw =
                static_cast<std::int64_t>(30'000.0 * (1.0 + t * static_cast<double>(i + 1) - std::floor(t)));
            const double position = 3.094e-5 * static_cast<double>(raw);
            const std::array<std::uint8_t, 8> bytes{0x9C, 30, static_cast<std::uint8_t>(raw), 1, 2, 3, 4, 5};
            const auto id = static_cast<std::uint32_t>(0x141 + i);
            recorder_.frame(bus_, {.at = now, .direction = wire::Direction::request, .bytes = bytes, .can_id = id});
            recorder_.frame(bus_, {.at = now,
                                   .direction = wire::Direction::reply,
                                   .bytes = bytes,
                                   .can_id = id,
                                   .verdict = bus::Verdict::taken});
            recorder_.state(joints_[i], {.at = now,
                                         .position_rad = {position, now},
                                         .velocity_rad_s = {0.017453 * static_cast<double>(raw % 360), now},
                                         .current_a = {0.016113281 * static_cast<double>(raw % 100), now},
                                         .temperature_c = {30.0, now}});
            recorder_.command(joints_[i], now, {.mode = actuator::Mode::position, .position_rad = position + 1e-3});
        }
    }
    static constexpr double pushes = 4.0 * joints;

private:
    record::Recorder& recorder_;
    record::Recorder::Bus bus_;
    std::array<record::Recorder::Joint, joints> joints_;
};

} // namespace

std::expected<RecordResult, Error> measure_recording(double minutes)
{
    const auto path = std::filesystem::temp_directory_path() / fmt::format("sinew-bench-{}.mcap", ::getpid());
    auto recorder = record::Recorder::create(path, {.zero = record::Time{std::chrono::seconds(1'700'000'000)}});
    if (!recorder)
        return std::unexpected(recorder.error());
    const auto bus = (*recorder)->add_bus({.name = "legs", .family = "rmd", .can = true, .bit_rate = 1'000'000});
    std::array<record::Recorder::Joint, joints> names{};
    for (std::size_t i = 0; i < joints; ++i)
        names[i] = (*recorder)->add_joint({.name = fmt::format("joint{}", i), .bus = "legs", .family = "rmd"});
    Robot robot(**recorder, bus, names);
    RecordResult out{.simulated_min = minutes};
    const auto cycles = static_cast<std::int64_t>(minutes * cycles_per_minute);
    double push_s = 0.0, write_s = 0.0;
    std::uint64_t allocations = 0;
    std::expected<void, Error> written;
    for (std::int64_t i = 0; written && i < cycles; i += cycles_per_drain) {
        const double begin = processor_s();
        const auto before = support::allocations();
        for (std::int64_t j = i; j < std::min(i + cycles_per_drain, cycles); ++j)
            robot.run(TimePoint{} + j * cycle);
        allocations += support::allocations() - before;
        const double pushed = processor_s();
        written = (*recorder)->drain();
        push_s += pushed - begin;
        write_s += processor_s() - pushed;
    }
    const double begin = processor_s();
    const auto finished = (*recorder)->finish();
    write_s += processor_s() - begin;
    std::error_code none;
    out.bytes_per_min = static_cast<double>(std::filesystem::file_size(path, none)) / minutes;
    std::filesystem::remove(path, none);
    if (!written || !finished)
        return std::unexpected(written ? finished.error() : written.error());
    out.push_s_per_min = push_s / minutes;
    out.write_s_per_min = write_s / minutes;
    out.share = (push_s + write_s) / (60.0 * minutes);
    out.push_ns = 1e9 * push_s / (static_cast<double>(cycles) * Robot::pushes);
    out.messages = (*recorder)->messages();
    out.dropped = (*recorder)->dropped();
    out.allocations = static_cast<double>(allocations);
    return out;
}

} // namespace sinew::bench
