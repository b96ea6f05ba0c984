#include "sinew/bus/bus.hpp"
#include "sinew/bus/fake_scripted_for_tests.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <vector>

/// A frame of which the port has taken a part is finished before anything else goes out.
namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};

/// Time that passes only where somebody waits, and then at once to the deadline. A wait ends at once, as that of the
/// kernel does, while one of its descriptors is readable.
class WakingClock final : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        for (const auto& handle : handles)
            if (pollfd ready{.fd = handle.fd, .events = POLLIN, .revents = 0}; ::poll(&ready, 1, 0) > 0)
                return;
        const bool has_room_first = has_room > now_ && has_room < deadline;
        const TimePoint next = has_room_first ? has_room : deadline;
        ASSERT_NE(next, TimePoint::max()) << "a wait without an end";
        now_ = std::max(now_, next);
    }

    TimePoint has_room = TimePoint::max(); ///< when the port takes bytes again

private:
    TimePoint now_{1s};
};

/// A port that takes half a frame, and the rest of it when it has room again.
class HalfLink final : public link::ByteLink
{
public:
    explicit HalfLink(WakingClock& clock) : clock_(clock) {}

    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        const bool has_room = clock_.now() >= clock_.has_room || ++tries > 1000;
        const std::size_t room = has_room ? bytes.size() : written.empty() ? first_part : 0;
        written.insert(written.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(room));
        return room;
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t>) override { return link::Arrival{}; }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = true, .bit_rate = 100'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    std::vector<std::uint8_t> written;
    int tries = 0; ///< without room
    std::size_t first_part = 0;

private:
    WakingClock& clock_;
};

/// A command of which the port took the first bytes, and a stop that is set.
class BusHalfFrame : public ::testing::TestWithParam<std::size_t>
{
protected:
    void SetUp() override
    {
        link_.first_part = GetParam();
        clock_.has_room = clock_.now() + 100ms;
        bus_.set_stop({&stop_, 1});
        bus_.start({&set_, 1}, {&result_, 1});
        EXPECT_FALSE(drive({&self_, 1}, clock_.now() + 1ms));
        ASSERT_EQ(link_.written.size(), link_.first_part);
        link_.tries = 0;
    }

    void expect_written(std::initializer_list<wire::Request> requests)
    {
        std::vector<std::uint8_t> frames;
        for (const auto& request : requests)
            frames.insert(frames.end(), request.frame.bytes().begin(), request.frame.bytes().end());
        EXPECT_EQ(link_.written, frames);
        EXPECT_LE(link_.tries, 5) << "it spun";
    }
    static wire::Request unanswered(std::uint8_t value)
    {
        auto set = *wire::make_request(3, fake::Set{.value = value});
        set.answered = false;
        return set;
    }

    WakingClock clock_;
    std::unique_ptr<HalfLink> made_ = std::make_unique<HalfLink>(clock_);
    HalfLink& link_ = *made_;
    Bus bus_{"half", link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made_)}}, clock_, framed};
    Bus* const self_ = &bus_;
    const wire::Request set_ = unanswered(9);
    const wire::Request stop_ = unanswered(0);
    Result result_;
};

TEST_P(BusHalfFrame, IsFinishedBeforeAStopAndNobodySpins)
{
    bus_.request_stop();
    EXPECT_TRUE(drive({&self_, 1}));
    expect_written({set_, stop_});
    EXPECT_EQ(result_.error.code, Errc::stopped);
    EXPECT_TRUE(bus_.stop_results()[0].good);
    EXPECT_FALSE(bus_.handles()[0].wants_write) << "nothing is left to write";
}

TEST_P(BusHalfFrame, OfAnExchangeThatIsOverHoldsUpNoStopBeyondItsRest)
{
    bus_.start({}, {});
    EXPECT_EQ(result_.error.code, Errc::stopped);
    bus_.stop();
    EXPECT_EQ(clock_.now(), clock_.has_room + 400us) << "the stop went out with the rest of the frame";
    expect_written({set_, stop_});
    EXPECT_TRUE(bus_.stop_results()[0].good);
}

TEST_P(BusHalfFrame, OfAnExchangeThatIsOverCountsForNoRequestOfTheNext)
{
    const wire::Request next = unanswered(7);
    Result next_result;
    bus_.start({&next, 1}, {&next_result, 1});
    EXPECT_EQ(result_.error.code, Errc::stopped);
    EXPECT_TRUE(drive({&self_, 1}));
    EXPECT_TRUE(next_result.good);
    expect_written({set_, next});
}

INSTANTIATE_TEST_SUITE_P(OfSoManyBytes, BusHalfFrame, ::testing::Values(1U, 2U, 3U));

/// An adapter that takes a part of a frame, refuses the rest of it, and stays open.
class BusRefusedRest : public ::testing::Test
{
protected:
    void begin_with_two_bytes()
    {
        line_.link.rooms = {2};
        line_.bus.start({&set_, 1}, {&result_, 1});
        ASSERT_FALSE(line_.bus.work());
    }
    void refuse_the_rest()
    {
        line_.link.refuses = true;
        EXPECT_TRUE(line_.bus.work());
        line_.link.refuses = false;
    }
    std::vector<std::uint8_t> behind_two_bytes(const wire::Frame& frame) const
    {
        std::vector<std::uint8_t> all = fake::bytes_of(set_.frame);
        all.resize(2);
        all.insert(all.end(), frame.bytes().begin(), frame.bytes().end());
        return all;
    }

    fake::Scripted<link::ByteLink> line_{framed};
    const wire::Request set_ = *wire::make_request(3, fake::Set{.value = 9});
    const wire::Request read_ = *wire::make_request(4, fake::Read{});
    Result result_;
};

TEST_F(BusRefusedRest, IsNotFinishedByTheNextExchange)
{
    begin_with_two_bytes();
    EXPECT_TRUE(line_.bus.handles()[0].wants_write);
    refuse_the_rest();
    EXPECT_EQ(result_.error.code, Errc::link_failed);
    EXPECT_FALSE(line_.bus.handles()[0].wants_write) << "nothing is left to write";
    line_.link.answers = {{0x55, 4, 1, 42}};
    EXPECT_TRUE(line_.bus.call(4, fake::Read{}).has_value());
    EXPECT_EQ(line_.link.all_written(), behind_two_bytes(read_.frame));
}

TEST_F(BusRefusedRest, OfAnExchangeThatIsOverCountsForNoRequestOfTheNext)
{
    begin_with_two_bytes();
    line_.bus.start({}, {});
    refuse_the_rest();
    line_.link.rooms = {2};
    line_.link.answers = {{0x55, 4, 1, 42}};
    EXPECT_TRUE(line_.bus.call(4, fake::Read{}).has_value());
    EXPECT_EQ(line_.link.all_written(), behind_two_bytes(read_.frame));
}

} // namespace
} // namespace sinew::bus
