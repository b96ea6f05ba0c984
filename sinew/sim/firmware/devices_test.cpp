#include "sinew/family/families.hpp"
#include "sinew/sim/firmware/bench_for_tests.hpp"
#include "sinew/sim/firmware/devices.hpp"
#include "sinew/sim/firmware/ratings.hpp"
#include "tests/support/allocations.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

TEST(Devices, AllocateNothingWhileTheyHearAndMove)
{
    for (const Family* family : families()) {
        const auto spec = make_spec(*family, family->name == "sam" ? "SAM-160" : "", "", 1);
        ASSERT_TRUE(spec);
        std::vector<wire::Frame> frames;
        for (const auto* message : line_of(*spec).messages) {
            if (!message->request.exists())
                continue;
            const auto values = sample_values(*message, options_of(*spec));
            const auto frame = wire::encode(*message, wire::Direction::request, 1, values, options_of(*spec));
            ASSERT_TRUE(frame) << message->name();
            frames.push_back(*frame);
        }
        frames.push_back(frames.front());
        frames.back().data[3] ^= 0x55; // broken on its way

        std::size_t answers = 0;
        for (const wire::Frame& frame : frames) {
            const auto device = make_device(*spec, plant_of(*spec));
            device->run(supply_v(*spec));
            const auto before = support::allocations();
            answers += device->hear(frame, TimePoint{}).has_value();
            for (int i = 0; i < 20; ++i)
                device->run(supply_v(*spec));
            EXPECT_EQ(support::allocations(), before) << family->name;
        }
        EXPECT_GT(answers, 9U) << family->name;
    }
}

TEST(Devices, AreMadeFromWhatARobotFileMeans)
{
    for (const Family* family : families()) {
        const auto spec = make_spec(*family, family->name == "sam" ? "SAM-20" : "", "", 7);
        ASSERT_TRUE(spec);
        const auto device = make_device(*spec, plant_of(*spec));
        EXPECT_EQ(device->id(), 7);
        EXPECT_EQ(device->bit_rate(), 0U) << "without power";
        device->run(supply_v(*spec));
        EXPECT_EQ(device->bit_rate(), family->default_bit_rate);
        EXPECT_EQ(&device->protocol(), family->protocol);
    }
}

} // namespace
} // namespace sinew::sim
