#include "sinew/link/slcan.hpp"

#include "sinew/link/link_test_support.hpp"
#include "sinew/link/pty.hpp"
#include "sinew/link/slcan_adapter.hpp"
#include "sinew/link/slcan_opening.hpp"

#include <fmt/format.h>
#include <random>
#include <vector>

namespace sinew::link {
namespace {

const wire::Frame request{.can_id = 0x141, .size = 2, .data = {0x9A, 0x00}};
const wire::Frame reply{.can_id = 0x141, .size = 3, .data = {0x9A, 0x01, 0xFF}};

class Slcan : public ::testing::Test
{
protected:
    /// Opens over a script; `adapter_` is what the link owns.
    auto open(std::deque<std::string> answers, std::uint32_t bit_rate = 1'000'000)
    {
        auto adapter = std::make_unique<test::ScriptedLink>();
        adapter_ = adapter.get();
        adapter_->reads = std::move(answers);
        return SlcanLink::open(std::move(adapter), bit_rate, clock_);
    }
    void open_silent()
    {
        auto opened = open({});
        ASSERT_TRUE(opened) << to_sentence(opened.error());
        link_ = std::move(*opened);
        adapter_->written.clear();
    }
    const SlcanLink::Counters& counters() const { return static_cast<const SlcanLink&>(*link_).counters(); }
    std::vector<wire::Frame> read_all(std::size_t at_once = 8)
    {
        std::vector<wire::Frame> frames;
        std::vector<wire::Frame> into(at_once);
        for (;;) {
            const auto arrival = link_->read(into);
            EXPECT_TRUE(arrival);
            frames.insert(frames.end(), into.begin(), into.begin() + arrival->count);
            if (arrival->count == 0 && adapter_->reads.empty())
                return frames;
        }
    }

    test::HurryingClock clock_;
    test::ScriptedLink* adapter_ = nullptr;
    std::unique_ptr<CanLink> link_;
};

TEST_F(Slcan, ClosesWhatIsOpenThenSetsTheRateAndOpens)
{
    auto link = open({"\r\r"}, 500'000);
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ(adapter_->written, "\rC\rS6\rO\r");
    EXPECT_EQ((*link)->state().bit_rate, 500'000u);
    EXPECT_TRUE((*link)->state().open);
}

TEST_F(Slcan, TakesSilenceOfAnAdapterThatNeverAcknowledgesForYes)
{
    open_silent();
    EXPECT_LE(clock_.time, TimePoint{} + std::chrono::milliseconds{400});
}

TEST_F(Slcan, RefusesARateWithoutACode)
{
    const auto link = open({}, 333'000);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::unsupported);
    open_silent();
    EXPECT_EQ(link_->set_bit_rate(333'000).error().code, Errc::unsupported);
    EXPECT_EQ(adapter_->written, "");
}

TEST_F(Slcan, IsNotFoundWhereNoPortIs)
{
    RealClock clock;
    const auto link = open_slcan(*parse_uri("slcan:/dev/ttyNOSUCH"), clock);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::link_not_found);
}

TEST_F(Slcan, WritesFramesAsText)
{
    open_silent();
    const wire::Frame frames[] = {request, reply};
    EXPECT_EQ(link_->write(frames).value(), 2u);
    EXPECT_EQ(adapter_->written, "t14129A00\rt14139A01FF\r");
}

TEST_F(Slcan, RefusesAFrameThatIsNoneOfCanBeforeAnythingIsSent)
{
    open_silent();
    const wire::Frame too_long[] = {request, {.can_id = 1, .size = 9}};
    EXPECT_EQ(link_->write(too_long).error().code, Errc::bad_length);
    const wire::Frame too_high[] = {request, {.can_id = 0x800, .size = 1}};
    EXPECT_EQ(link_->write(too_high).error().code, Errc::out_of_range);
    EXPECT_EQ(adapter_->written, "");
}

TEST_F(Slcan, KeepsTheTextWholeWhenTheAdapterTakesItInPieces)
{
    open_silent();
    adapter_->room = 3;
    const wire::Frame frames[] = {request, reply};
    EXPECT_EQ(link_->write(frames).value(), 2u);
    EXPECT_EQ(adapter_->written, "t14");
    EXPECT_TRUE(static_cast<SlcanLink&>(*link_).wants_write());
    adapter_->room = 9;
    read_all();
    EXPECT_EQ(adapter_->written, "t14129A00\rt1");
    adapter_->room = 100;
    EXPECT_EQ(link_->write({}).value(), 0u);
    EXPECT_EQ(adapter_->written, "t14129A00\rt14139A01FF\r");
    EXPECT_FALSE(static_cast<SlcanLink&>(*link_).wants_write());
}

TEST_F(Slcan, TakesNoMoreFramesThanItCanHold)
{
    open_silent();
    adapter_->room = 0;
    const std::vector<wire::Frame> many(500, request);
    const std::size_t taken = link_->write(many).value();
    EXPECT_GT(taken, 0u);
    EXPECT_LT(taken, many.size());
    EXPECT_EQ(link_->write(many).value(), 0u);
    adapter_->room = 1'000'000;
    read_all();
    EXPECT_EQ(adapter_->written.size(), taken * std::string_view{"t14129A00\r"}.size());
}

TEST_F(Slcan, ReadsTheSameFramesHoweverTheStreamIsSplit)
{
    const unsigned seed = std::random_device{}();
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random{seed};
    std::vector<wire::Frame> sent;
    std::string stream;
    for (int i = 0; i < 10'000; ++i) {
        wire::Frame frame{.can_id = static_cast<std::uint32_t>(random() % 0x800),
                          .size = static_cast<std::uint8_t>(random() % 9)};
        for (std::size_t k = 0; k < frame.size; ++k)
            frame.data[k] = static_cast<std::uint8_t>(random());
        sent.push_back(frame);
        std::array<std::uint8_t, slcan::longest_frame_text> text;
        const std::size_t size = slcan::encode(frame, text);
        stream.append(text.begin(), text.begin() + size);
        stream += std::array{"", "z\r", "\a", "\r", "T1FFFFFFF0\r", "F00\r"}[random() % 6];
    }
    for (const std::size_t at_once : {1u, 3u, 64u}) {
        open_silent();
        for (std::size_t at = 0; at < stream.size();) {
            const std::size_t size = 1 + random() % 300;
            adapter_->reads.push_back(stream.substr(at, size));
            at += size;
        }
        ASSERT_EQ(read_all(at_once), sent) << "reading " << at_once << " at once";
    }
}

TEST_F(Slcan, CountsWhatItDoesNotPassOn)
{
    open_silent();
    adapter_->reads = {"T1FFFFFFF2AABB\rr1410\r", "t1412AA\r", std::string(100, 't') + "\r", "z\rF00\rV1013\r\r"};
    EXPECT_TRUE(read_all().empty());
    EXPECT_EQ(counters().foreign, 2u);
    EXPECT_EQ(counters().malformed, 2u);
    EXPECT_EQ(counters().refused, 0u);
}

TEST_F(Slcan, ReportsARefusalOnceAtTheNextWriteWhichGoesOutAllTheSame)
{
    open_silent();
    adapter_->reads = {"z\r\a\a"};
    EXPECT_TRUE(read_all().empty());
    EXPECT_EQ(counters().refused, 2u);
    const auto written = link_->write({&request, 1});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, Errc::link_failed);
    EXPECT_NE(adapter_->written, "") << "a stop must not be lost to the refusal of an earlier frame";
    EXPECT_EQ(link_->write({&request, 1}).value(), 1u);
}

TEST_F(Slcan, AsksAnAdapterThatRefusedForItsFlagsAndTellsThem)
{
    open_silent();
    adapter_->reads = {"\a"};
    read_all();
    EXPECT_EQ(adapter_->written, "F\r");
    adapter_->reads = {"FA1\r"};
    read_all();
    EXPECT_EQ(static_cast<SlcanLink&>(*link_).flags(), 0xA1);
    EXPECT_EQ(counters().overruns, 1u);
    EXPECT_EQ(to_sentence(link_->write({&request, 1}).error()),
              "the SLCAN adapter refused a command or frame (BEL) and reports bus error, error passive, receive queue "
              "full; does the bus have power, termination and its rate?");
    EXPECT_EQ(link_->write({&request, 1}).value(), 1u);
}

TEST_F(Slcan, DoesNotAskAnAdapterAgainThatRefusesTheQuestion)
{
    open_silent();
    adapter_->reads = {"\a"};
    read_all();
    adapter_->reads = {"\a"}; // the answer to F
    read_all();
    EXPECT_EQ(counters().refused, 1u);
    ASSERT_FALSE(link_->write({&request, 1}));
    EXPECT_EQ(link_->write({&request, 1}).value(), 1u) << "the question is no refusal of a frame";
    adapter_->reads = {"\a"};
    read_all();
    EXPECT_EQ(counters().refused, 2u);
    EXPECT_EQ(adapter_->written.find("F\r"), adapter_->written.rfind("F\r"));
    EXPECT_FALSE(link_->write({&request, 1})) << "later refusals are told";
}

TEST_F(Slcan, TellsFlagsWhenItIsAsked)
{
    open_silent();
    auto& link = static_cast<SlcanLink&>(*link_);
    EXPECT_TRUE(link.ask_flags());
    EXPECT_FALSE(link.ask_flags()) << "the answer is due";
    adapter_->reads = {"z\rF08\r"};
    read_all();
    EXPECT_EQ(adapter_->written, "F\r");
    EXPECT_EQ(link.flags(), slcan::flag::overrun);
    EXPECT_EQ(counters().overruns, 1u);
    EXPECT_EQ(link_->write({&request, 1}).value(), 1u) << "that is no refusal";
}

TEST_F(Slcan, ChangesTheRateOfCan)
{
    open_silent();
    EXPECT_EQ(link_->set_bit_rate(250'000).value(), 250'000u);
    EXPECT_EQ(adapter_->written, "C\rS5\rO\r");
    EXPECT_EQ(link_->state().bit_rate, 250'000u);
}

/// A port with an adapter behind it, without anything between.
class AdapterPort final : public ByteLink
{
public:
    AdapterPort(SlcanAdapter& adapter, std::vector<wire::Frame>& bus) : adapter_(adapter), bus_(bus) {}
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        adapter_.take(bytes, [&](const wire::Frame& frame) {
            bus_.push_back(frame);
            return true;
        });
        return bytes.size();
    }
    std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override
    {
        const std::size_t count = std::min(into.size(), adapter_.pending().size());
        std::ranges::copy(adapter_.pending().first(count), into.begin());
        adapter_.drop(count);
        return Arrival{.count = count, .at = {}};
    }
    int handle() const override { return -1; }
    LinkState state() const override { return {.open = true}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

private:
    SlcanAdapter& adapter_;
    std::vector<wire::Frame>& bus_;
};

TEST_F(Slcan, OpensAnAdapterThatAnotherProgramLeftOpenWithAHalfWrittenLine)
{
    SlcanAdapter adapter;
    std::vector<wire::Frame> bus;
    AdapterPort left{adapter, bus};
    ASSERT_TRUE(left.write(test::bytes("S4\rO\rt1412AA")));
    ASSERT_TRUE(adapter.offer(reply));

    auto link = SlcanLink::open(std::make_unique<AdapterPort>(adapter, bus), 1'000'000, clock_);
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ(adapter.bit_rate(), 1'000'000u);
    EXPECT_TRUE(bus.empty());
    ASSERT_EQ((*link)->write({&request, 1}).value(), 1u);
    ASSERT_EQ(bus.size(), 1u);
    EXPECT_EQ(bus[0], request);

    link->reset();
    EXPECT_FALSE(adapter.is_open()) << "the adapter must not go on talking to nobody";
}

TEST_F(Slcan, FailsWhenTheAdapterRefuses)
{
    class Refusing final : public ByteLink
    {
    public:
        std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
        {
            bells_ += static_cast<std::size_t>(std::ranges::count(bytes, '\r'));
            return bytes.size();
        }
        std::expected<Arrival, Error> read(std::span<std::uint8_t> into) override
        {
            const std::size_t count = std::min(into.size(), std::exchange(bells_, 0));
            std::ranges::fill(into.first(count), '\a');
            return Arrival{.count = count, .at = {}};
        }
        int handle() const override { return -1; }
        LinkState state() const override { return {.open = true}; }
        std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    private:
        std::size_t bells_ = 0;
    };
    const auto link = SlcanLink::open(std::make_unique<Refusing>(), 1'000'000, clock_);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, Errc::link_failed);
    EXPECT_EQ(to_sentence(link.error()), "the SLCAN adapter refuses 1000000 bit/s; is it an SLCAN adapter?");
}

TEST_F(Slcan, TalksToAnAdapterBehindAPseudoTerminal)
{
    RealClock real;
    auto master = PtyMaster::open(9600, real);
    ASSERT_TRUE(master);
    SlcanAdapter adapter;
    std::vector<wire::Frame> bus;
    test::ServingClock clock{(*master)->handle(), [&] {
                                 std::array<std::uint8_t, 256> into;
                                 const auto arrival = (*master)->read(into);
                                 ASSERT_TRUE(arrival);
                                 adapter.take(std::span(into).first(arrival->count), [&](const wire::Frame& frame) {
                                     bus.push_back(frame);
                                     return adapter.offer(reply);
                                 });
                                 adapter.drop((*master)->write(adapter.pending()).value());
                             }};
    auto link = open_slcan(*parse_uri(fmt::format("slcan:{}?bitrate=500000", (*master)->device())), clock);
    ASSERT_TRUE(link) << to_sentence(link.error());
    EXPECT_EQ(adapter.bit_rate(), 500'000u);
    EXPECT_TRUE(adapter.is_open());
    EXPECT_EQ((*master)->client_bit_rate(), 115'200u);

    ASSERT_EQ((*link)->write({&request, 1}).value(), 1u);
    std::array<wire::Frame, 4> into;
    std::size_t count = 0;
    EXPECT_TRUE(test::until(clock, (*link)->handle(), [&] {
        count = (*link)->read(into).value().count;
        return count != 0;
    }));
    EXPECT_EQ(bus, std::vector{request});
    ASSERT_EQ(count, 1u);
    EXPECT_EQ(into[0], reply);

    master->reset();
    EXPECT_TRUE(test::until(real, (*link)->handle(), [&] { return !(*link)->read(into); }));
    EXPECT_EQ((*link)->write({&request, 1}).error().code, Errc::link_lost);
    EXPECT_FALSE((*link)->state().open);
}

} // namespace
} // namespace sinew::link
