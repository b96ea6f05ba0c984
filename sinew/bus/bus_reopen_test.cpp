#include "sinew/bus/bus.hpp"
#include "sinew/bus/fake_family.hpp"
#include "sinew/link/virtual.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <vector>

namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};
const fake::FakeProtocol bare{true};

/// A device on an adapter that comes and goes, with the clock of both: time passes only where somebody waits.
class Adapter final : public link::Clock, public link::ByteSink
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        const auto arrival = link_ != nullptr ? link_->next_arrival() : std::nullopt;
        now_ = std::max(now_, std::min(deadline, arrival.value_or(TimePoint::max())));
        if (now_ >= returns_at)
            plugged = true;
    }

    std::expected<link::AnyLink, Error> open()
    {
        ++tries;
        if (!plugged)
            return fail(Errc::link_not_found, "there is no device");
        auto made = std::make_unique<link::VirtualByteLink>(*this, *this, 100'000);
        link_ = made.get();
        return link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made)}};
    }
    void pull_out()
    {
        plugged = false;
        returns_at = TimePoint::max();
        link_->hang_up();
    }
    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t bit_rate) override
    {
        heard.emplace_back(bytes.begin(), bytes.end());
        heard_at.push_back(now_);
        heard_rate = bit_rate;
        if (bytes.size() != 4)
            return;
        if (bytes[2] == 3 || bytes[2] == 4) // bare-read, bare-ping
            link_->deliver(std::array<std::uint8_t, 2>{bytes[1], bytes[1]}, now_ + 1ms);
        else
            link_->deliver(std::array<std::uint8_t, 4>{0x55, bytes[1], bytes[2], 42}, now_ + 1ms);
    }
    void on_close() override { link_ = nullptr; }

    bool plugged = true;
    TimePoint returns_at = TimePoint::max();
    int tries = 0;
    std::vector<std::vector<std::uint8_t>> heard;
    std::vector<TimePoint> heard_at;
    std::uint32_t heard_rate = 0;

private:
    link::VirtualByteLink* link_ = nullptr;
    TimePoint now_{1s};
};

class BusReopen : public ::testing::Test
{
protected:
    /// The adapter's device answers after 1 ms at any bit rate.
    explicit BusReopen(const wire::Protocol& protocol = framed)
        : bus_("arm", *adapter_.open(), adapter_, protocol, {.paced = false})
    {
        bus_.set_reopen([this] { return adapter_.open(); });
        adapter_.tries = 0;
    }

    Errc call()
    {
        const auto number = bus_.call(3, fake::Read{});
        return number ? Errc{} : number.error().code;
    }
    void pass(Duration time) { adapter_.wait({}, adapter_.now() + time); }

    static constexpr Errc fine{};
    Adapter adapter_;
    Bus bus_;
};

class BareBusReopen : public BusReopen
{
protected:
    BareBusReopen() : BusReopen(bare) {}
};

TEST_F(BusReopen, HasItsLinkBackWithin200MillisecondsOfTheDevice)
{
    for (int i = 0; i < 1000; ++i) {
        ASSERT_EQ(call(), fine);
        adapter_.pull_out();
        ASSERT_EQ(call(), Errc::link_lost);
        adapter_.returns_at = adapter_.now() + std::chrono::milliseconds(i);
        while (call() == Errc::link_lost)
            pass(7ms);
        ASSERT_LE(adapter_.now() - adapter_.returns_at, 200ms) << "after " << i << " ms";
    }
    EXPECT_EQ(bus_.losses(), 1000U);
    EXPECT_EQ(bus_.link_trouble(), nullptr);
}

TEST_F(BusReopen, EndsAtOnceAndTriesOnceInAPeriodWhileTheDeviceIsGone)
{
    adapter_.pull_out();
    ASSERT_EQ(call(), Errc::link_lost);
    const TimePoint before = adapter_.now();
    for (int i = 0; i < 1000; ++i) {
        ASSERT_EQ(call(), Errc::link_lost);
        pass(1ms);
    }
    EXPECT_EQ(adapter_.now() - before, 1s) << "a call waited";
    EXPECT_EQ(adapter_.tries, 10);
    EXPECT_EQ(bus_.call(3, fake::Read{}).error().detail, "arm is lost and not back yet: there is no device");
}

TEST_F(BusReopen, EndsAllThatWaitsWhenTheLinkIsLost)
{
    const auto request = *wire::make_request(3, fake::Read{});
    const std::array requests{request, request, request};
    std::array<Result, 3> results;
    bus_.start(requests, results);
    EXPECT_FALSE(bus_.work());
    adapter_.pull_out();
    EXPECT_TRUE(bus_.work());
    for (const Result& result : results)
        EXPECT_EQ(result.reply().error().code, Errc::link_lost);
}

TEST_F(BusReopen, AnExchangeFailsAsAWholeForAsLongAsTheLinkIsLost)
{
    adapter_.pull_out();
    const auto read = *wire::make_request(3, fake::Read{});
    const std::array requests{read, read};
    std::array<Result, 2> results;
    for (const std::size_t count : {1U, 2U, 1U, 2U}) {
        const auto done = bus_.exchange(std::span(requests).first(count), std::span(results).first(count));
        ASSERT_FALSE(done.has_value()) << count << " of them";
        EXPECT_EQ(done.error().code, Errc::link_lost);
        pass(1s);
    }
    adapter_.plugged = true;
    EXPECT_TRUE(bus_.exchange(requests, results).has_value());
}

TEST_F(BusReopen, AStopThatALossCutShortGoesOutAgainWhenTheLinkIsBack)
{
    auto stop = *wire::make_request(3, fake::Set{.value = 0});
    stop.answered = false;
    bus_.set_stop({&stop, 1});
    bus_.request_stop();
    ASSERT_FALSE(bus_.work()) << "its bits are on the wire";
    adapter_.pull_out();
    EXPECT_TRUE(bus_.work());
    EXPECT_EQ(bus_.stop_results()[0].error.code, Errc::link_lost);
    adapter_.plugged = true;
    adapter_.heard.clear();
    pass(100ms);
    Bus* const self = &bus_;
    EXPECT_TRUE(drive({&self, 1}));
    ASSERT_EQ(adapter_.heard.size(), 1U);
    EXPECT_TRUE(std::ranges::equal(adapter_.heard[0], stop.frame.bytes()));
    EXPECT_TRUE(bus_.stop_results()[0].good);
}

TEST_F(BusReopen, TellsOfALossAlthoughNothingWasAskedMeanwhile)
{
    adapter_.pull_out();
    bus_.tend();
    ASSERT_NE(bus_.link_trouble(), nullptr);
    EXPECT_EQ(bus_.link_trouble()->code, Errc::link_lost);
    adapter_.plugged = true;
    EXPECT_EQ(bus_.tend(), TimePoint::max());
    EXPECT_EQ(bus_.link_trouble(), nullptr);
    EXPECT_EQ(call(), Errc::link_lost) << "the devices may have lost their power";
    EXPECT_TRUE(adapter_.heard.empty());
    EXPECT_EQ(call(), fine);
}

TEST_F(BusReopen, TellsOfEveryLossOnce)
{
    for (int i = 0; i < 3; ++i) {
        adapter_.pull_out();
        adapter_.plugged = true;
        EXPECT_EQ(call(), Errc::link_lost);
        EXPECT_EQ(call(), fine);
        pass(1s);
    }
}

TEST_F(BusReopen, SetsTheLastBitRateAgain)
{
    ASSERT_EQ(bus_.set_bit_rate(9600).value(), 9600U);
    adapter_.pull_out();
    EXPECT_EQ(call(), Errc::link_lost);
    adapter_.plugged = true;
    pass(100ms);
    EXPECT_EQ(call(), fine);
    EXPECT_EQ(adapter_.heard_rate, 9600U);
    EXPECT_EQ(bus_.link_state().bit_rate, 9600U);
}

TEST_F(BusReopen, LeavesTheBitRateWithWhichTheLinkWasOpened)
{
    adapter_.pull_out();
    EXPECT_EQ(call(), Errc::link_lost);
    adapter_.plugged = true;
    pass(100ms);
    EXPECT_EQ(call(), fine);
    EXPECT_EQ(bus_.link_state().bit_rate, 100'000U);
    EXPECT_EQ(bus_.conversation().line().bit_rate, 100'000U);
}

TEST_F(BusReopen, RefusesALinkOfAnotherKind)
{
    struct Sink final : link::CanSink {
        void on_write(std::span<const wire::Frame>, std::uint32_t) override {}
    } sink;
    bus_.set_reopen([&]() -> std::expected<link::AnyLink, Error> {
        return std::unique_ptr<link::CanLink>{std::make_unique<link::VirtualCanLink>(adapter_, sink, 1'000'000)};
    });
    adapter_.pull_out();
    EXPECT_EQ(call(), Errc::link_lost);
    EXPECT_NE(to_sentence(bus_.call(3, fake::Read{}).error()).find("another kind"), std::string::npos);
}

TEST_F(BusReopen, StaysLostWhereNobodySaysHowItComesBack)
{
    bus_.set_reopen({});
    adapter_.pull_out();
    adapter_.plugged = true;
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(call(), Errc::link_lost);
        pass(1s);
    }
    EXPECT_EQ(adapter_.tries, 0);
    EXPECT_FALSE(bus_.wait_for_link(adapter_.now() + 1s));
}

TEST_F(BusReopen, WaitsForItsLinkUntilItIsTime)
{
    EXPECT_TRUE(bus_.wait_for_link(adapter_.now()));
    adapter_.pull_out();
    const TimePoint until = adapter_.now() + 1s;
    EXPECT_FALSE(bus_.wait_for_link(until));
    EXPECT_EQ(adapter_.now(), until);
    adapter_.returns_at = adapter_.now() + 330ms;
    EXPECT_TRUE(bus_.wait_for_link(TimePoint::max()));
    EXPECT_LE(adapter_.now() - adapter_.returns_at, 100ms);
}

TEST_F(BusReopen, WaitsForItsLinkNoLongerThanUntilAStop)
{
    adapter_.pull_out();
    bus_.request_stop();
    EXPECT_FALSE(bus_.wait_for_link(TimePoint::max()));
}

TEST_F(BusReopen, ComesBackWhileItsNeighboursWork)
{
    Adapter& clock = adapter_;
    adapter_.pull_out();
    EXPECT_EQ(call(), Errc::link_lost);
    const auto request = *wire::make_request(3, fake::Read{});
    Result result;
    bus_.start({&request, 1}, {&result, 1});
    Bus* const both[] = {&bus_};
    EXPECT_TRUE(drive(both, clock.now() + 1s)) << "a lost link does not hold up the others";
    EXPECT_EQ(result.reply().error().code, Errc::link_lost);
}

TEST_F(BareBusReopen, PutsTheLineInQuarantineFirst)
{
    ASSERT_TRUE(bus_.call(3, fake::BareRead{}).has_value());
    adapter_.pull_out();
    ASSERT_FALSE(bus_.call(3, fake::BareRead{}).has_value());
    adapter_.plugged = true;
    adapter_.heard.clear();
    adapter_.heard_at.clear();
    const TimePoint back = adapter_.now();
    ASSERT_TRUE(bus_.call(3, fake::BareRead{}).has_value());
    ASSERT_EQ(adapter_.heard.size(), 2U);
    EXPECT_EQ(adapter_.heard[0][2], 4) << "the device names itself first";
    EXPECT_EQ(adapter_.heard_at[0] - back, Settings{}.late_max) << "after silence";
    EXPECT_EQ(adapter_.heard[1][2], 3);
}

} // namespace
} // namespace sinew::bus
