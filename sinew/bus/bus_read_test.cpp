#include "sinew/bus/bus.hpp"
#include "sinew/bus/fake_unusual.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <numeric>
#include <vector>

/// How often a bus reads its link before it waits: until there is no more.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};

/// Time that passes only where somebody waits.
class CountingClock final : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        ++waits;
        now_ = std::min(deadline, now_ + 100us); // then something arrives
    }
    int waits = 0;

private:
    TimePoint now_{1s};
};

/// A CAN link that hands out what was laid ready, one portion at each read.
class PortionLink final : public link::CanLink
{
public:
    struct Portion {
        std::vector<wire::Frame> frames;
        bool more = false;
    };

    std::expected<std::size_t, Error> write(std::span<const wire::Frame> frames) override
    {
        if (is_gone_before)
            return std::unexpected(Error{.code = Errc::link_lost});
        written += frames.size();
        return frames.size();
    }
    std::expected<link::Arrival, Error> read(std::span<wire::Frame> into) override
    {
        ++reads;
        if (portions.empty())
            return is_gone ? std::expected<link::Arrival, Error>(std::unexpected(Error{.code = Errc::link_lost}))
                           : link::Arrival{};
        const Portion portion = portions.front();
        portions.pop_front();
        EXPECT_LE(portion.frames.size(), into.size());
        std::ranges::copy(portion.frames, into.begin());
        return link::Arrival{.count = portion.frames.size(), .at = TimePoint{1s + 1ms}, .more = portion.more};
    }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = true, .bit_rate = 1'000'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    std::deque<Portion> portions;
    bool is_gone = false; ///< after the portions
    bool is_gone_before = false;
    int reads = 0;
    std::size_t written = 0;
};

class BusRead : public ::testing::Test
{
protected:
    static wire::Frame answer(unsigned id) { return {.can_id = 0x100 + id, .size = 2, .data = {5, 1}}; }
    /// Asks devices 1 to 3 at once. Whether all have answered without a time-out.
    bool ask()
    {
        std::vector<wire::Request> requests;
        for (const int id : {1, 2, 3})
            requests.push_back(*wire::make_request(id, fake::CanRead{}));
        std::vector<Result> results(requests.size());
        EXPECT_TRUE(bus_.exchange(requests, results).has_value());
        return std::ranges::all_of(results, &Result::good);
    }

    CountingClock clock_;
    Result result_;
    std::unique_ptr<PortionLink> made_ = std::make_unique<PortionLink>();
    PortionLink& link_ = *made_;
    Bus bus_{"portions", link::AnyLink{std::unique_ptr<link::CanLink>{std::move(made_)}}, clock_, framed};
};

TEST_F(BusRead, GoesOnWhileTheLinkSaysThatThereIsMore)
{
    link_.portions = {{{answer(1)}, true}, {{answer(2)}, true}, {{answer(3)}}};
    EXPECT_TRUE(ask());
    EXPECT_EQ(clock_.waits, 1);
    EXPECT_EQ(link_.reads, 3);
}

TEST_F(BusRead, GoesOnWhereAsManyCameAsWereAskedFor)
{
    std::vector<wire::Frame> full(64, answer(9)); // strays
    full.front() = answer(1);
    link_.portions = {{full}, {{answer(2), answer(3)}}};
    EXPECT_TRUE(ask());
    EXPECT_EQ(clock_.waits, 1);
    EXPECT_EQ(link_.reads, 2);
    EXPECT_EQ(bus_.conversation().counters().strays, 63U);
}

TEST_F(BusRead, EndsWhereThereIsNoMore)
{
    link_.portions = {{{answer(1)}}, {{answer(2)}}, {{answer(3)}}};
    EXPECT_TRUE(ask());
    EXPECT_EQ(clock_.waits, 3) << "a read of nothing costs a system call";
}

TEST_F(BusRead, OfOneRequestReadsOnWhereThereIsMore)
{
    link_.portions = {{{answer(2)}, true}, {{answer(1)}}};
    EXPECT_TRUE(bus_.call(2, fake::CanRead{}).has_value());
    EXPECT_EQ(link_.reads, 2) << "what came behind the answer is not left for the next one";
    EXPECT_EQ(bus_.conversation().counters().strays, 1U);
    link_.portions = {{{answer(1), answer(2)}}};
    EXPECT_TRUE(bus_.call(2, fake::CanRead{}).has_value());
    EXPECT_EQ(bus_.conversation().counters().strays, 2U);
}

TEST_F(BusRead, OfOneRequestEndsWhereTheLinkIsGone)
{
    link_.is_gone = true;
    const auto number = bus_.call(2, fake::CanRead{});
    ASSERT_FALSE(number.has_value());
    EXPECT_EQ(number.error().code, Errc::link_lost);
    EXPECT_EQ(clock_.waits, 1);
    link_.is_gone_before = true;
    EXPECT_EQ(bus_.call(2, fake::CanRead{}).error().code, Errc::link_lost);
    EXPECT_EQ(clock_.waits, 1) << "there is nothing to wait for";
}

TEST_F(BusRead, OfOneRequestReadsOnceMoreWhereSomethingElseCameFirst)
{
    link_.portions = {{{answer(1)}}, {{answer(2)}}};
    EXPECT_TRUE(bus_.call(2, fake::CanRead{}).has_value());
    EXPECT_EQ(link_.reads, 2) << "a read of nothing costs a system call";
    EXPECT_EQ(clock_.waits, 2);
    const auto of_all = *wire::make_request(0, fake::ReadAll{}); // goes out only where nothing is outstanding
    bus_.start({&of_all, 1}, {&result_, 1});
    EXPECT_FALSE(bus_.work());
    EXPECT_EQ(link_.written, 2U);
}

} // namespace
} // namespace sinew::bus
