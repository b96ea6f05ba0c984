#include "tests/can/can_test_support.hpp"

#include "sinew/bus/bus.hpp"
#include "sinew/family/rmd/framing.hpp"
#include "sinew/family/rmd/messages.hpp"
#include "sinew/link/links.hpp"
#include "tests/support/leaks.hpp"

/// An interface of the kernel that goes down and comes up again and again; see tests/scenario/replug_test.cpp.
namespace sinew::link::test {
namespace {

using sinew::test::Leaks, sinew::test::replugs, sinew::test::warm_up;

struct CanReplug : testing::Test {
    void SetUp() override { shell("ip link add dev vcan9 type vcan && ip link set vcan9 up"); }
    void TearDown() override { shell("ip link del vcan9"); }

    /// A request that nobody answers, and what came of it.
    std::expected<void, Error> tell(bus::Bus& bus)
    {
        wire::Request request = *wire::make_request(1, rmd::MotorStop{});
        request.answered = false;
        bus::Result result;
        return bus.exchange({&request, 1}, {&result, 1});
    }

    RealClock clock;
};

TEST_F(CanReplug, OfAnInterfaceThatGoesDownAndComesUpLeavesNothingBehind)
{
    const auto links = Links::system();
    bus::Bus bus("legs", *links.open("can:vcan9?bitrate=1000000", clock), clock, rmd::protocol());
    bus.set_reopen(links.reopener("can:vcan9?bitrate=1000000", clock), 1ms);
    Leaks leaks(0);
    for (int i = 0; i < replugs() + warm_up; ++i) {
        leaks.round(i);
        const auto other = open({.interface = "vcan9"}, clock);
        ASSERT_TRUE(tell(bus));
        ASSERT_EQ(read(*other, clock, 1).size(), 1u) << i;
        set_up("vcan9", false);
        const auto lost = tell(bus);
        ASSERT_FALSE(lost);
        ASSERT_EQ(lost.error().code, Errc::link_lost);
        ASSERT_FALSE(bus.wait_for_link(clock.now() + 5ms)) << "it is still down";
        set_up("vcan9", true);
        ASSERT_TRUE(bus.wait_for_link(clock.now() + patience)) << to_sentence(*bus.link_trouble());
    }
    EXPECT_EQ(bus.losses(), static_cast<std::uint64_t>(replugs() + warm_up));
}

} // namespace
} // namespace sinew::link::test
