#include "sinew/link/slcan_opening.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/links.hpp"
#include "sinew/link/pty.hpp"

namespace sinew::link {
namespace {

TEST(SlcanAfterALoss, IsOpenedAgainWithoutWaitingForAnAdapterThatNeverAcknowledges)
{
    test::HurryingClock clock;
    auto master = PtyMaster::open(9600, clock);
    ASSERT_TRUE(master);
    const auto reopen = Links::system().reopener("slcan:" + (*master)->device(), clock);
    const auto first = reopen();
    EXPECT_EQ(clock.time, TimePoint{}) << "the other buses of the same loop stand still meanwhile";
    EXPECT_FALSE(first);
    clock.time += std::chrono::milliseconds{99};
    EXPECT_FALSE(reopen());
    clock.time += std::chrono::milliseconds{1};
    const auto link = reopen();
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ(clock.time, TimePoint{} + std::chrono::milliseconds{100});
    EXPECT_EQ(std::get<std::unique_ptr<CanLink>>(*link)->state().bit_rate, 1'000'000u);
}

class SlcanReopened : public ::testing::Test
{
protected:
    std::expected<std::unique_ptr<CanLink>, Error> step() { return reopening_.step(); }
    void pass(int milliseconds) { clock_.time += std::chrono::milliseconds{milliseconds}; }

    test::HurryingClock clock_;
    test::ScriptedLink* adapter_ = nullptr; ///< of the latest step that began anew
    std::size_t room_ = 1000;
    int opened_ = 0;
    SlcanReopening reopening_{[this]() -> std::expected<std::unique_ptr<ByteLink>, Error> {
                                  ++opened_;
                                  auto adapter = std::make_unique<test::ScriptedLink>();
                                  adapter_ = adapter.get();
                                  adapter_->room = room_;
                                  return adapter;
                              },
                              500'000, clock_};
};

TEST_F(SlcanReopened, IsThereAsSoonAsAllIsAcknowledged)
{
    EXPECT_FALSE(step());
    EXPECT_EQ(adapter_->written, "\rC\rS6\rO\r");
    adapter_->reads = {"\r\a\r"};
    EXPECT_FALSE(step());
    adapter_->reads = {"\r"};
    const auto link = step();
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ((*link)->state().bit_rate, 500'000u);
    EXPECT_EQ(clock_.time, TimePoint{});
}

TEST_F(SlcanReopened, LeavesTheRestOfALineToTheLink)
{
    EXPECT_FALSE(step());
    adapter_->reads = {"\r\r\r\rt1413"};
    auto link = step();
    ASSERT_TRUE(link);
    adapter_->reads = {"9A01FF\r"};
    std::array<wire::Frame, 2> into;
    EXPECT_EQ((*link)->read(into).value().count, 1u);
    EXPECT_EQ(into[0], (wire::Frame{.can_id = 0x141, .size = 3, .data = {0x9A, 0x01, 0xFF}}));
}

TEST_F(SlcanReopened, BeginsAnewAfterARefusal)
{
    for (const std::string refusal : {"\r\a\a\r", "\r\a\r\a", "\a\r\a", "\a\a\a\a"}) {
        EXPECT_FALSE(step());
        adapter_->reads = {refusal};
        pass(100);
        const auto link = step();
        ASSERT_FALSE(link);
        EXPECT_EQ(to_sentence(link.error()), "the SLCAN adapter refuses to open its CAN bus at 500000 bit/s again; "
                                             "unplug it and plug it in again");
    }
    EXPECT_EQ(opened_, 4);
    EXPECT_FALSE(step());
    EXPECT_EQ(opened_, 5);
}

TEST_F(SlcanReopened, IsNotRefusedByAnAdapterThatOnlySaysThatItWasClosed)
{
    EXPECT_FALSE(step());
    adapter_->reads = {"\a"};
    pass(100);
    EXPECT_TRUE(step());
}

TEST_F(SlcanReopened, SendsTheRestLaterAndGivesUpAnAdapterThatTakesNoBytes)
{
    room_ = 3;
    EXPECT_FALSE(step());
    adapter_->room = 100;
    EXPECT_FALSE(step());
    EXPECT_EQ(adapter_->written, "\rC\rS6\rO\r");
    pass(100);
    EXPECT_TRUE(step());
    EXPECT_FALSE(step());
    pass(100);
    const auto link = step();
    ASSERT_FALSE(link);
    EXPECT_EQ(to_sentence(link.error()), "the SLCAN adapter takes no bytes; unplug it and plug it in again");
}

TEST_F(SlcanReopened, HasNoLinkAtARateWithoutACode)
{
    SlcanReopening reopening{[]() -> std::expected<std::unique_ptr<ByteLink>, Error> { return nullptr; }, 333'000,
                             clock_};
    EXPECT_EQ(reopening.step().error().code, Errc::unsupported);
}

} // namespace
} // namespace sinew::link
