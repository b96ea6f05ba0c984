#include "tests/bus/rig.hpp"

#include <gtest/gtest.h>

/// In virtual time a bus loses nothing to the wire: what the bits and the devices need is all that passes.
namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

constexpr double enough = 0.99;
constexpr int cycles = 20;

Station::Answer sam_answers(Duration delay)
{
    return [=](const wire::Frame& request, TimePoint) -> std::optional<sim::Answer> {
        const auto id = static_cast<std::uint8_t>(request.data[1] & 0x1F);
        return sim::Answer{*wire::encode_reply<sam::QuickReadStatus>(id, {.load = 1, .position = id}), delay};
    };
}

Station::Answer nuri_answers(Duration delay)
{
    return [=](const wire::Frame& request, TimePoint) -> std::optional<sim::Answer> {
        return sim::Answer{*wire::encode_reply<nuri::RequestPositionFeedback>(request.data[2], {.position = 4711}),
                           delay};
    };
}

Station::Answer rmd_answers(Duration delay)
{
    return [=](const wire::Frame& request, TimePoint) -> std::optional<sim::Answer> {
        const auto id = static_cast<int>(request.can_id - 0x140);
        return sim::Answer{*wire::encode_reply<rmd::ReadStatus2>(id, {.temperature = 30, .speed = 300}), delay};
    };
}

template <class M>
std::vector<wire::Request> one_each(int first, int count, Duration response)
{
    std::vector<wire::Request> requests;
    for (int id = first; id < first + count; ++id)
        requests.push_back(*wire::make_request(id, M{}, {}, response));
    return requests;
}

/// Cycles of one read of each device; returns how long they took. All must succeed.
Duration run_cycles(bus::Bus& bus, std::span<const wire::Request> requests)
{
    std::vector<bus::Result> results(requests.size());
    const TimePoint start = bus.clock().now();
    for (int i = 0; i < cycles; ++i) {
        EXPECT_TRUE(bus.exchange(requests, results).has_value());
        for (const auto& result : results)
            EXPECT_TRUE(result.good) << to_sentence(result.error);
    }
    return bus.clock().now() - start;
}

double share(Duration limit, Duration took)
{
    return static_cast<double>(limit.count()) / static_cast<double>(took.count());
}

TEST(WireLimit, ThirtyOneSamServosAtOneAndAHalfMegabit)
{
    WireClock clock;
    SerialRig rig(clock, sam::protocol(), 1'500'000);
    for (int id = 0; id < 31; ++id)
        rig.add(id, sam_answers(10us));
    const auto requests = one_each<sam::QuickReadStatus>(0, 31, 10us);
    const Duration limit = cycles * bus::predict_cycle({.bit_rate = 1'500'000}, requests);
    EXPECT_GE(share(limit, run_cycles(*rig.bus, requests)), enough);
}

TEST(WireLimit, SixteenNuriServosAtOneMegabit)
{
    WireClock clock;
    SerialRig rig(clock, nuri::protocol(), 1'000'000);
    for (int id = 0; id < 16; ++id)
        rig.add(id, nuri_answers(100us));
    const auto requests = one_each<nuri::RequestPositionFeedback>(0, 16, 100us);
    const Duration limit = cycles * bus::predict_cycle({.bit_rate = 1'000'000}, requests);
    EXPECT_GE(share(limit, run_cycles(*rig.bus, requests)), enough);
}

TEST(WireLimit, ThirtyTwoRmdMotorsAtOneMegabitPipelined)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    for (int id = 1; id <= 32; ++id)
        rig.add(id, rmd_answers(100us));
    const auto requests = one_each<rmd::ReadStatus2>(1, 32, 100us);
    const Duration took = run_cycles(*rig.bus, requests);
    // The bits that these frames really have, and once a cycle the answer that nobody can wait for usefully.
    const Duration limit = bit_time(rig.bits, 1'000'000) + cycles * 100us;
    EXPECT_GE(share(limit, took), enough);
    EXPECT_LE(took, cycles * bus::predict_cycle({.can = true, .bit_rate = 1'000'000}, requests));
    EXPECT_EQ(rig.wire.counters().error_frames, 0U);
}

TEST(WireLimit, ThreeBusesOfDifferentSpeedOnOneClockReachTheirOwnEach)
{
    WireClock clock;
    SerialRig sam(clock, sam::protocol(), 1'500'000);
    SerialRig nuri(clock, nuri::protocol(), 115'200);
    CanRig rmd(clock, 1'000'000);
    for (int id = 1; id <= 8; ++id) {
        sam.add(id, sam_answers(10us));
        nuri.add(id, nuri_answers(100us));
        rmd.add(id, rmd_answers(100us));
    }
    struct Lane {
        bus::Bus* bus;
        std::vector<wire::Request> requests;
        std::vector<bus::Result> results;
        std::function<Duration(int cycles)> limit;
        int done = 0;
        Duration took{};  ///< up to the end of the latest cycle
        Duration needs{}; ///< the least for as many
    };
    const auto of_serial = [](const Lane& lane) {
        return [&lane](int done) { return done * bus::predict_cycle(lane.bus->conversation().line(), lane.requests); };
    };
    const auto of_can = [&rmd](int done) { return bit_time(rmd.bits, 1'000'000) + done * 100us; };
    Lane lanes[] = {{&*sam.bus, one_each<sam::QuickReadStatus>(1, 8, 10us), {}, of_serial(lanes[0])},
                    {&*nuri.bus, one_each<nuri::RequestPositionFeedback>(1, 8, 100us), {}, of_serial(lanes[1])},
                    {&*rmd.bus, one_each<rmd::ReadStatus2>(1, 8, 100us), {}, of_can}};
    for (Lane& lane : lanes) {
        lane.results.resize(8);
        lane.bus->start(lane.requests, lane.results);
    }
    const TimePoint start = clock.now();
    const TimePoint end = start + 200ms;
    while (clock.now() < end) {
        TimePoint deadline = end;
        for (Lane& lane : lanes) {
            while (lane.bus->work()) {
                lane.took = clock.now() - start;
                lane.needs = lane.limit(++lane.done);
                lane.bus->start(lane.requests, lane.results);
            }
            deadline = std::min(deadline, lane.bus->deadline());
        }
        clock.wait({}, deadline);
    }
    for (const Lane& lane : lanes)
        EXPECT_GE(share(lane.needs, lane.took), enough) << lane.done;
    EXPECT_GT(lanes[0].done, 10 * lanes[1].done) << "the slow one held up the fast one";
}

TEST(WireLimit, CommandsWithoutAnswersFollowEachOtherWithoutAGap)
{
    WireClock clock;
    SerialRig rig(clock, nuri::protocol(), 1'000'000);
    std::vector<wire::Request> requests;
    for (int i = 0; i < 50; ++i)
        requests.push_back(*wire::make_request(1, nuri::RequestPing{}));
    for (auto& request : requests)
        request.answered = false;
    std::vector<bus::Result> results(requests.size());
    const TimePoint start = clock.now();
    ASSERT_TRUE(rig.bus->exchange(requests, results).has_value());
    EXPECT_EQ(clock.now() - start, 50 * 60us);
}

} // namespace
} // namespace sinew::tests
