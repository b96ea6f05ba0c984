#include "sinew/link/virtual.hpp"

#include "sinew/link/link_test_support.hpp"

#include <vector>

namespace sinew::link {
namespace {

using std::chrono::microseconds;

struct Wire final : ByteSink {
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate) override
    {
        written.append(bytes.begin(), bytes.end());
        rate = bit_rate;
    }
    void on_close() override { closed = true; }
    std::string written;
    std::uint32_t rate = 0;
    bool closed = false;
};

class Virtual : public ::testing::Test
{
protected:
    std::string read(std::size_t size, TimePoint* at = nullptr)
    {
        std::vector<std::uint8_t> into(size);
        const auto arrival = link_->read(into);
        EXPECT_TRUE(arrival);
        if (at != nullptr)
            *at = arrival->at;
        return {into.begin(), into.begin() + arrival->count};
    }

    test::HurryingClock clock_;
    Wire wire_;
    std::unique_ptr<VirtualByteLink> link_ = std::make_unique<VirtualByteLink>(clock_, wire_, 115200);
};

TEST_F(Virtual, GivesWhatIsWrittenToTheWireAtOnceWithItsRate)
{
    EXPECT_EQ(link_->write(test::bytes("abc")).value(), 3u);
    EXPECT_EQ(wire_.written, "abc");
    EXPECT_EQ(wire_.rate, 115200u);
    EXPECT_EQ(link_->set_bit_rate(9600).value(), 9600u);
    EXPECT_EQ(link_->state().bit_rate, 9600u);
    EXPECT_EQ(link_->write(test::bytes("d")).value(), 1u);
    EXPECT_EQ(wire_.rate, 9600u);
    EXPECT_EQ(link_->set_bit_rate(0).error().code, Errc::unsupported);
    EXPECT_EQ(link_->handle(), -1);
}

TEST_F(Virtual, IsReadWhenItsTimeHasComeAndNotBefore)
{
    const TimePoint at = clock_.time + microseconds{100};
    ASSERT_TRUE(link_->deliver(test::bytes("abc"), at));
    EXPECT_EQ(link_->next_arrival(), at);
    clock_.time = at - Duration{1};
    EXPECT_EQ(read(10), "");
    clock_.time = at;
    TimePoint seen;
    EXPECT_EQ(read(10, &seen), "abc");
    EXPECT_EQ(seen, at);
    EXPECT_EQ(link_->next_arrival(), std::nullopt);
    EXPECT_EQ(read(10), "");
}

TEST_F(Virtual, KeepsTheTimeOfEveryRunEvenWhenItIsReadLateOrInParts)
{
    const TimePoint first = clock_.time + microseconds{10};
    const TimePoint second = first + microseconds{10};
    ASSERT_TRUE(link_->deliver(test::bytes("abc"), first));
    ASSERT_TRUE(link_->deliver(test::bytes("de"), second));
    clock_.time = second + microseconds{500};
    TimePoint at;
    EXPECT_EQ(read(2, &at), "ab");
    EXPECT_EQ(at, first);
    EXPECT_EQ(read(10, &at), "c");
    EXPECT_EQ(at, first);
    EXPECT_EQ(read(10, &at), "de");
    EXPECT_EQ(at, second);
}

TEST_F(Virtual, NeverLetsARunOvertakeTheOneBefore)
{
    const TimePoint at = clock_.time + microseconds{10};
    ASSERT_TRUE(link_->deliver(test::bytes("a"), at));
    ASSERT_TRUE(link_->deliver(test::bytes("b"), at - microseconds{5}));
    clock_.time = at;
    TimePoint seen;
    EXPECT_EQ(read(10), "a");
    EXPECT_EQ(read(10, &seen), "b");
    EXPECT_EQ(seen, at);
}

TEST_F(Virtual, DropsWhatNobodyReadsAndCountsIt)
{
    const std::string run(1000, 'x');
    std::size_t taken = 0;
    while (link_->deliver(test::bytes(run), clock_.time))
        ++taken;
    EXPECT_EQ(taken, 4u);
    EXPECT_EQ(link_->dropped(), 1000u);
    EXPECT_EQ(read(1000), run);
    EXPECT_TRUE(link_->deliver(test::bytes(run), clock_.time));
}

TEST_F(Virtual, KeepsItsOrderOverManyTimesItsCapacity)
{
    std::uint8_t next_in = 0;
    std::uint8_t next_out = 0;
    for (int round = 0; round < 2000; ++round) {
        std::array<std::uint8_t, 37> run;
        for (auto& byte : run)
            byte = next_in++;
        ASSERT_TRUE(link_->deliver(run, clock_.time));
        for (const std::size_t size : {20u, 20u})
            for (const char byte : read(size))
                ASSERT_EQ(static_cast<std::uint8_t>(byte), next_out++);
    }
    EXPECT_EQ(next_in, next_out);
}

TEST_F(Virtual, IsLostWhenTheWireIsUnplugged)
{
    ASSERT_TRUE(link_->deliver(test::bytes("abc"), clock_.time));
    link_->hang_up();
    std::array<std::uint8_t, 4> into;
    EXPECT_EQ(link_->read(into).error().code, Errc::link_lost);
    EXPECT_EQ(link_->write(test::bytes("x")).error().code, Errc::link_lost);
    EXPECT_EQ(link_->set_bit_rate(9600).error().code, Errc::link_lost);
    EXPECT_FALSE(link_->state().open);
    EXPECT_EQ(link_->next_arrival(), std::nullopt);
    EXPECT_FALSE(link_->deliver(test::bytes("x"), clock_.time));
    EXPECT_EQ(wire_.written, "");
}

TEST_F(Virtual, TellsTheWireWhenItGoes)
{
    EXPECT_FALSE(wire_.closed);
    link_.reset();
    EXPECT_TRUE(wire_.closed);
}

TEST_F(Virtual, TellsTheWireOfAHangUpOnceAndNotAgainWhenANewLinkMayBeThere)
{
    link_->hang_up();
    EXPECT_TRUE(wire_.closed);
    wire_.closed = false;
    link_.reset();
    EXPECT_FALSE(wire_.closed);
}

TEST(VirtualCan, CarriesFramesBothWays)
{
    struct CanWire final : CanSink {
        void on_write(std::span<const wire::Frame> frames, std::uint32_t) override
        {
            written.assign(frames.begin(), frames.end());
        }
        std::vector<wire::Frame> written;
    } wire;
    test::HurryingClock clock;
    VirtualCanLink link{clock, wire, 1000000};
    const wire::Frame frames[] = {{.can_id = 0x141, .size = 8}, {.can_id = 0x142, .size = 2, .data = {1, 2}}};
    EXPECT_EQ(link.write(frames).value(), 2u);
    ASSERT_EQ(wire.written.size(), 2u);
    EXPECT_EQ(wire.written[1], frames[1]);

    ASSERT_TRUE(link.deliver(std::span(frames).first(1), clock.time + microseconds{130}));
    ASSERT_TRUE(link.deliver(std::span(frames).last(1), clock.time + microseconds{200}));
    std::array<wire::Frame, 4> into;
    EXPECT_EQ(link.read(into)->count, 0u);
    clock.time += microseconds{300};
    const auto first = link.read(into);
    ASSERT_TRUE(first);
    ASSERT_EQ(first->count, 1u);
    EXPECT_EQ(first->at, TimePoint{} + microseconds{130});
    EXPECT_EQ(into[0], frames[0]);
    EXPECT_EQ(link.read(into)->at, TimePoint{} + microseconds{200});
}

} // namespace
} // namespace sinew::link
