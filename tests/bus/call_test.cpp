#include "tests/bus/rig.hpp"

#include <gtest/gtest.h>

namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

TEST(Call, OfAMessageForSeveralMotorsTakesTheAnswersOfAllThatAreThere)
{
    WireClock clock;
    CanRig rig(clock, 1'000'000);
    for (const int id : {1, 2, 3})
        rig.add(id, [=](const wire::Frame&, TimePoint) -> std::optional<sim::Answer> {
            return sim::Answer{*wire::encode_reply<rmd::TorqueClosedLoop>(id, {.temperature = 30}), 100us * id};
        });
    const auto ids = wire::info_of<rmd::MultiMotorTorque>.request.layout->ids;
    const auto done = rig.bus->call(static_cast<int>(ids.low), rmd::MultiMotorTorque{});
    ASSERT_TRUE(done.has_value()) << to_sentence(done.error());
    EXPECT_EQ(done->temperature, 30);
    clock.wait({}, clock.now() + 5ms);
    rig.bus->tend();
    EXPECT_EQ(rig.bus->conversation().counters().strays, 0U) << "an answer was left over";
}

TEST(Call, ToAllDevicesAtOnceWaitsForNobody)
{
    WireClock clock;
    SerialRig rig(clock, sam::protocol(), 1'000'000);
    int heard = 0;
    rig.add(3, [&](const wire::Frame&, TimePoint) -> std::optional<sim::Answer> {
        ++heard;
        return {};
    });
    constexpr int all = 31;
    const TimePoint start = clock.now();
    (void)rig.bus->call(all, sam::QuickBrakeMode{});
    const auto asked = *wire::make_request(all, sam::QuickBrakeMode{});
    EXPECT_EQ(clock.now() - start, predict(rig.bus->conversation().line(), asked).request);
    EXPECT_EQ(heard, 1);
    EXPECT_EQ(rig.bus->conversation().counters().timeouts, 0U);
    EXPECT_EQ(rig.bus->conversation().counters().quarantines, 0U);
}

} // namespace
} // namespace sinew::tests
