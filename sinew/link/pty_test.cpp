#include "sinew/link/pty.hpp"

#include "sinew/link/link_test_support.hpp"

namespace sinew::link {
namespace {

TEST(PtyMaster, IsSeenWithItsOwnRateUntilAProgramSetsOne)
{
    RealClock clock;
    const auto master = PtyMaster::open(57600, clock);
    ASSERT_TRUE(master);
    EXPECT_EQ((*master)->client_bit_rate(), 57600u);
    EXPECT_EQ((*master)->state().bit_rate, 57600u);
    EXPECT_EQ((*master)->set_bit_rate(9600).error().code, Errc::unsupported);
}

TEST(PtyMaster, EchoesNothingBeforeAProgramOpensIt)
{
    RealClock clock;
    const auto master = PtyMaster::open(57600, clock);
    ASSERT_TRUE(master);
    ASSERT_TRUE((*master)->write(test::bytes("anybody?\r\n")));
    std::array<std::uint8_t, 16> into;
    EXPECT_EQ((*master)->read(into)->count, 0u);
}

TEST(PtyMaster, DoesNotWaitForAProgramThatReadsNothing)
{
    RealClock clock;
    const auto master = PtyMaster::open(57600, clock);
    ASSERT_TRUE(master);
    const std::string much(1 << 20, 'x');
    std::size_t taken = 0;
    for (std::size_t count = 1; count != 0; taken += count) {
        const auto written = (*master)->write(test::bytes(much));
        ASSERT_TRUE(written);
        count = *written;
    }
    EXPECT_GT(taken, 0u);
    EXPECT_TRUE((*master)->state().open);
}

} // namespace
} // namespace sinew::link
