#include "sinew/sim/firmware/sam_program.hpp"

#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/sam_device.hpp"
#include "tests/support/covers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using test::covers;
using Lines = std::vector<wire::Pair>;

/// The example of L1515: between 82 and 172, 266 ms each.
const Lines example{{0x10, 0x52}, {0x31, 0x0A}, {0x10, 0xAC}, {0x31, 0x0A}};

std::array<wire::Pair, 8> eight(const Lines& lines)
{
    std::array<wire::Pair, 8> out{};
    std::ranges::copy(lines, out.begin());
    return out;
}

/// What a program does in so many ticks: "tick:instruction,data".
std::string run(const Lines& lines, int ticks, const sam::DeviceOptions& options = {},
                SamProgram::Senses senses = {.position = 127, .ad = 100})
{
    SamProgram program;
    program.start(eight(lines), static_cast<int>(lines.size()), options);
    std::string out;
    for (int k = 0; k < ticks; ++k) {
        program.tick_begins();
        while (const auto action = program.next(senses))
            out += std::to_string(k) + ":" + std::to_string(static_cast<int>(action->instruction)) + "," +
                   std::to_string(action->data) + " ";
    }
    return out + (program.is_running() ? "runs" : "stopped");
}

TEST(SamProgram, OfTheManualGoesToAndFroEvery266Milliseconds)
{
    covers("A.14 4");
    EXPECT_EQ(run(example, 800), "0:1,82 266:1,172 532:1,82 798:1,172 runs");
}

TEST(SamProgram, StopsAtItsEndWhenBuiltSo)
{
    covers("A.14 4");
    EXPECT_EQ(run(example, 800, {.motion_wrap = sam::MotionWrap::stop}), "0:1,82 266:1,172 stopped");
}

TEST(SamProgram, KnowsEveryInstruction)
{
    covers("A.14 2");
    EXPECT_EQ(run({{0x00, 0}, {0x14, 9}, {0x23, 7}, {0x40, 3}, {0x80, 0}}, 1), "0:1,9 0:2,7 0:4,3 stopped");
    EXPECT_EQ(run({{0x3F, 0xFE}, {0x10, 1}, {0x80, 0}}, 4095), "4094:1,1 stopped") << "4094 ms";
    EXPECT_EQ(run({{0x90, 0}, {0xF0, 0}, {0x10, 1}, {0x80, 0}}, 1), "0:1,1 stopped") << "undefined ones do nothing";
}

TEST(SamProgram, WaitsForAConditionOfPositionOrInput)
{
    covers("A.14 2");
    covers("A.14 5");
    const struct {
        int sub;
        bool less, equal, more; // of the current value than the data
    } conditions[] = {{1, false, true, false}, {2, false, false, true}, {3, true, false, false},
                      {4, false, true, true},  {5, true, true, false},  {6, false, false, false}};
    for (const auto& [sub, less, equal, more] : conditions)
        for (const auto& [value, holds] : {std::pair{49, less}, {50, equal}, {51, more}}) {
            const auto done = holds ? "0:1,1 stopped" : "runs";
            const auto command = [sub](int n) { return static_cast<std::uint8_t>(n << 4 | sub); };
            EXPECT_EQ(run({{command(5), 50}, {0x10, 1}, {0x80, 0}}, 9, {}, {.position = value}), done) << sub << value;
            EXPECT_EQ(run({{command(6), 50}, {0x10, 1}, {0x80, 0}}, 9, {}, {.ad = value}), done) << sub << value;
        }
}

TEST(SamProgram, RepeatsAsOftenAsToldAndStops)
{
    covers("A.14 5");
    const Lines three{{0x10, 9}, {0x30, 1}, {0x70, 3}};
    EXPECT_EQ(run(three, 99), "0:1,9 1:1,9 2:1,9 stopped");
    EXPECT_EQ(run(three, 99, {.motion_repeat = sam::MotionRepeat::additional}), "0:1,9 1:1,9 2:1,9 3:1,9 stopped");
    EXPECT_EQ(run({{0x10, 9}, {0x30, 1}, {0x70, 0}}, 3, {.motion_wrap = sam::MotionWrap::stop}),
              "0:1,9 1:1,9 2:1,9 runs");
}

TEST(SamProgram, WithoutADelayDoesNotHangTheDevice)
{
    EXPECT_EQ(run({{0x70, 0}}, 1000), "runs");
}

// ---- in a device ----

struct Own : Bench<SamDevice> {
    explicit Own(const char* model = "SAM-160", sam::DeviceOptions options = {.response_level = 1})
        : Bench(sam::Spec{.model = sam::find_model(model), .profile = sam::profiles()[0], .id = 5, .device = options})
    {
    }
    int write(const Lines& lines)
    {
        const auto count = static_cast<std::uint8_t>(lines.size());
        return ask(sam::WriteMotionData{.motion_count = count, .instructions = eight(lines)}).motion_count;
    }
    int position() { return ask(sam::QuickReadStatus{}).position; }
};

TEST(SamProgram, RunsInADeviceWithNothingButPower)
{
    covers("A.14 1");
    covers("A.14 5");
    Own bench("SAM-20");
    EXPECT_EQ(bench.write(example), 4);
    EXPECT_EQ(bench.ask(sam::ReadMotionData{}).motion_count, 4);
    const Lines slow{{0x10, 0x52}, {0x3F, 0x00}, {0x10, 0xAC}, {0x3F, 0x00}}; // 3840 ms each
    bench.write(slow);
    for (const bool cut : {false, true}) {
        if (cut)
            bench.device.power_cycle();
        bench.run(3s);
        EXPECT_EQ(bench.position(), 0x52);
        bench.run(4s);
        EXPECT_EQ(bench.position(), 0xAC);
        bench.run(4s);
        EXPECT_EQ(bench.position(), 0x52) << "it wraps";
    }
}

TEST(SamProgram, WaitsForPowerOnWhenBuiltSo)
{
    covers("A.14 5");
    Own bench("SAM-20", {.response_level = 1, .motion_runs_when_written = false});
    bench.write({{0x10, 0xAC}, {0x80, 0x00}});
    bench.run(2s);
    EXPECT_EQ(bench.position(), 127);
    bench.device.power_cycle();
    bench.run(2s);
    EXPECT_EQ(bench.position(), 0xAC);
}

TEST(SamProgram, IsTakenInQuickCoordinatesTooAndDisabledByACountOfZero)
{
    covers("A.14 1");
    covers("A.14 3");
    Own bench;
    bench.ask(sam::QuickWriteMotionData{.motion_count = 4, .instructions = eight(example)});
    EXPECT_EQ(bench.ask(sam::QuickReadMotionData{}).motion_count, 4);
    bench.write({});
    bench.device.power_cycle();
    bench.ask(sam::SpecialControl{.mode = sam::Mode::passive});
    bench.run(2s);
    EXPECT_EQ(bench.device.look().mode, "passive");
    EXPECT_FALSE(wire::encode_request(5, sam::WriteMotionData{.motion_count = 1, .instructions = {{{0x30, 0xFF}}}}))
        << "delays with a low byte of 0xFF cannot be sent";
}

TEST(SamProgram, GivesWayToACommandOfTheHostUntilThePowerIsCut)
{
    covers("A.14 5");
    Own bench("SAM-20");
    bench.write(example);
    bench.run(100ms);
    bench.ask(sam::ReadCurrentPosition{});
    bench.ask(sam::QuickPositionControl{.target_position = 127});
    bench.run(5s);
    EXPECT_EQ(bench.position(), 127);
    bench.device.power_cycle();
    bench.run(260ms);
    EXPECT_LT(bench.position(), 120);
}

TEST(SamProgram, DrivesModesAndOutputsAndLooksAtTheInput)
{
    covers("A.12 4");
    covers("A.14 2");
    covers("A.5 2");
    Own bench;
    bench.write({{0x23, 15}, {0x62, 100}, {0x40, 2}, {0x22, 0}, {0x30, 50}, {0x21, 0}, {0x80, 0}});
    bench.run(500ms);
    EXPECT_EQ(bench.device.look().mode, "wheel");
    EXPECT_LT(bench.device.look().velocity_rad_s, -1.0) << "counter-clockwise";
    EXPECT_FALSE(bench.device.port().do2);
    bench.device.set_external(101 * 16 * 0.001343); // 101 in 8 bit
    bench.run(10ms);
    EXPECT_TRUE(bench.device.port().do2);
    EXPECT_FALSE(bench.device.port().do1);
    EXPECT_EQ(bench.device.look().mode, "brake");
    bench.run(60ms);
    EXPECT_EQ(bench.device.look().mode, "passive");
}

} // namespace
} // namespace sinew::sim
