#include "sinew/bus/bus.hpp"

#include "sinew/bus/fake_family.hpp"
#include "sinew/link/virtual.hpp"
#include "tests/support/allocations.hpp"

#include <array>
#include <gtest/gtest.h>
#include <poll.h>
#include <thread>
#include <utility>
#include <vector>

namespace sinew::bus {
namespace {

using namespace std::chrono_literals;

const fake::FakeProtocol framed{false};

/// Time that passes only where somebody waits, and then at once to the deadline or to the next arrival of a link.
class JumpingClock : public link::Clock
{
public:
    TimePoint now() const override { return now_; }
    void wait(std::span<const link::Handle>, TimePoint deadline) override
    {
        TimePoint next = deadline;
        for (const auto* link : links)
            if (const auto arrival = link->next_arrival())
                next = std::min(next, std::max(*arrival, now_));
        ASSERT_NE(next, TimePoint::max()) << "a wait without an end";
        now_ = std::max(now_, next);
        ++waits;
    }

    std::vector<link::VirtualByteLink*> links;
    int waits = 0;

private:
    TimePoint now_{1s};
};

/// A device that answers every read with its value a while later.
class Responder final : public link::ByteSink
{
public:
    explicit Responder(JumpingClock& clock) : clock_(clock) {}

    void on_write(std::span<const std::uint8_t> bytes, std::uint32_t) override
    {
        heard.insert(heard.end(), bytes.begin(), bytes.end());
        if (answers && bytes.size() == 4)
            link->deliver(std::array<std::uint8_t, 4>{0x55, bytes[1], bytes[2], 42}, clock_.now() + delay);
    }

    link::VirtualByteLink* link = nullptr;
    bool answers = true;
    Duration delay = 3ms;
    std::vector<std::uint8_t> heard;

private:
    JumpingClock& clock_;
};

struct Rig {
    explicit Rig(JumpingClock& clock) : responder(clock)
    {
        auto made = std::make_unique<link::VirtualByteLink>(clock, responder, 100'000);
        link = responder.link = made.get();
        clock.links.push_back(link);
        bus.emplace("rig", link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made)}}, clock, framed);
    }

    Responder responder;
    link::VirtualByteLink* link = nullptr;
    std::optional<Bus> bus;
};

TEST(Bus, CallsADeviceAndReturnsItsTypedAnswer)
{
    JumpingClock clock;
    Rig rig(clock);
    const auto number = rig.bus->call(3, fake::Read{});
    ASSERT_TRUE(number.has_value()) << to_sentence(number.error());
    EXPECT_EQ(number->value, 42);
    EXPECT_EQ(clock.now().time_since_epoch(), 1s + 3ms);
}

TEST(Bus, AnExchangeOfOneRequestFailsAsAWholeOnlyWhenTheLinkIsLost)
{
    JumpingClock clock;
    Rig rig(clock);
    const auto request = *wire::make_request(3, fake::Read{});
    Result result;
    for (const bool answers : {true, false}) {
        rig.responder.answers = answers;
        EXPECT_TRUE(rig.bus->exchange({&request, 1}, {&result, 1}).has_value());
        EXPECT_EQ(result.good, answers);
    }
}

TEST(Bus, AsksNothingOfTheHeapInTheSteadyState)
{
    JumpingClock clock;
    Rig rig(clock);
    rig.responder.heard.reserve(10'000);
    const auto request = *wire::make_request(3, fake::Read{});
    const std::array requests{request, request, request};
    std::array<Result, 3> results;
    const auto before = support::allocations();
    for (int i = 0; i < 100; ++i)
        (void)rig.bus->exchange(requests, results);
    EXPECT_EQ(support::allocations(), before);
    EXPECT_TRUE(results[2].good);
}

TEST(Bus, SaysWhoDidNotAnswerAndHowLongItWaited)
{
    JumpingClock clock;
    Rig rig(clock);
    rig.responder.answers = false;
    const auto number = rig.bus->call(3, fake::Set{});
    ASSERT_FALSE(number.has_value());
    EXPECT_EQ(number.error().code, Errc::timeout);
    EXPECT_EQ(number.error().id, 3);
    EXPECT_EQ(number.error().message, "set");
    EXPECT_GT(number.error().elapsed, 0ns);
}

TEST(Bus, RefusesAMessageThatTheFirmwareLineDoesNotListAndSendsNothing)
{
    JumpingClock clock;
    Rig rig(clock);
    static constexpr auto listed = wire::catalogue<fake::Read>();
    static constexpr wire::Profile line{.name = "line", .messages = listed};
    rig.bus->set_device(3, {.line = &line});
    EXPECT_EQ(rig.bus->call(3, fake::Set{}).error().code, Errc::not_in_profile);
    EXPECT_EQ(rig.bus->send(3, fake::Set{}).error().code, Errc::not_in_profile);
    EXPECT_TRUE(rig.responder.heard.empty());
    EXPECT_TRUE(rig.bus->call(3, fake::Read{}).has_value());
    EXPECT_TRUE(rig.bus->send(3, fake::Read{}).has_value());
}

TEST(Bus, KnowsNothingOfAnIdThatNoDeviceCanHave)
{
    JumpingClock clock;
    Rig rig(clock);
    static constexpr wire::Profile line{.name = "line"};
    for (const int id : {-1, 0, 255, 256})
        rig.bus->set_device(id, {.line = &line});
    EXPECT_EQ(rig.bus->device(0).line, &line);
    EXPECT_EQ(rig.bus->device(255).line, &line);
    EXPECT_EQ(rig.bus->device(-1).line, nullptr);
    EXPECT_EQ(rig.bus->device(256).line, nullptr);
}

TEST(Bus, RefusesAnIdThatTheFamilyDoesNotHaveAndSendsNothing)
{
    JumpingClock clock;
    Rig rig(clock);
    EXPECT_EQ(rig.bus->call(10, fake::Read{}).error().code, Errc::bad_id);
    EXPECT_TRUE(rig.responder.heard.empty());
}

TEST(Bus, SendsWithoutWaitingForAnAnswer)
{
    JumpingClock clock;
    Rig rig(clock);
    rig.responder.answers = false;
    EXPECT_TRUE(rig.bus->send(3, fake::Set{.value = 9}).has_value());
    EXPECT_EQ(rig.responder.heard, (std::vector<std::uint8_t>{0x55, 3, 2, 9}));
    EXPECT_EQ(clock.now().time_since_epoch(), 1s + 400us) << "its own bits and no more";
    EXPECT_FALSE(rig.bus->conversation().busy());
}

TEST(Bus, EndsEveryCallWithTheReasonWhenTheLinkHangsUp)
{
    JumpingClock clock;
    Rig rig(clock);
    rig.link->hang_up();
    EXPECT_EQ(rig.bus->call(3, fake::Read{}).error().code, Errc::link_lost);
    EXPECT_EQ(rig.bus->call(3, fake::Read{}).error().code, Errc::link_lost);
}

/// An adapter that refuses one frame and stays open, or is gone when the answer is due.
class RefusingLink final : public link::ByteLink
{
public:
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        if (refuse)
            return fail(Errc::link_failed, "the adapter refused a frame");
        return bytes.size();
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t>) override
    {
        if (is_gone)
            return std::unexpected(Error{.code = Errc::link_lost});
        return link::Arrival{};
    }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = !is_gone, .bit_rate = 100'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    bool refuse = true;
    bool is_gone = false;
};

TEST(Bus, OutlivesAnAdapterThatRefusesOneFrame)
{
    JumpingClock clock;
    auto made = std::make_unique<RefusingLink>();
    RefusingLink& link = *made;
    Bus bus("refusing", link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made)}}, clock, framed);
    EXPECT_EQ(bus.send(3, fake::Set{}).error().code, Errc::link_failed);
    EXPECT_EQ(clock.waits, 0) << "there is nothing to wait for";
    link.refuse = false;
    EXPECT_TRUE(bus.send(3, fake::Set{}).has_value());
    link.is_gone = true;
    EXPECT_EQ(bus.call(3, fake::Read{}).error().code, Errc::link_lost);
}

/// A port whose other end has stopped to read.
class StuckLink final : public link::ByteLink
{
public:
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t>) override { return 0U; }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t>) override { return link::Arrival{}; }
    int handle() const override { return -1; }
    link::LinkState state() const override { return {.open = true, .bit_rate = 100'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }
};

TEST(Bus, GivesUpAPortThatTakesNoBytes)
{
    JumpingClock clock;
    Bus bus("stuck", link::AnyLink{std::unique_ptr<link::ByteLink>{std::make_unique<StuckLink>()}}, clock, framed);
    EXPECT_EQ(bus.send(3, fake::Set{}).error().code, Errc::link_failed);
    EXPECT_EQ(clock.now().time_since_epoch(), 1s + 1s);
    EXPECT_EQ(clock.waits, 1);
    bus.request_stop();
    EXPECT_EQ(bus.send(3, fake::Set{}).error().code, Errc::stopped);
}

TEST(Bus, IsStoppedFromAnotherThread)
{
    JumpingClock clock;
    Rig rig(clock);
    std::thread([&] { rig.bus->request_stop(); }).join();
    EXPECT_EQ(rig.bus->call(3, fake::Read{}).error().code, Errc::stopped);
    EXPECT_TRUE(rig.responder.heard.empty());
    rig.bus->clear_stop();
    EXPECT_TRUE(rig.bus->call(3, fake::Read{}).has_value());
}

TEST(Bus, AStopGoesOutAgainAfterItWasCleared)
{
    JumpingClock clock;
    Rig rig(clock);
    auto stop = *wire::make_request(3, fake::Set{.value = 0});
    stop.answered = false;
    rig.bus->set_stop({&stop, 1});
    for (std::size_t times = 1; times <= 3; ++times) {
        rig.bus->stop();
        EXPECT_EQ(rig.responder.heard.size(), times * stop.frame.size);
        rig.bus->clear_stop();
    }
}

TEST(Bus, AStopThatBeginsAfterItsTimeSendsWhatIsRightThen)
{
    JumpingClock clock;
    Rig rig(clock);
    auto hold = *wire::make_request(3, fake::Set{.value = 1}), brake = *wire::make_request(3, fake::Set{.value = 2});
    hold.answered = brake.answered = false;
    const std::array braked_twice{brake, brake};
    const auto sent = [&] { return std::exchange(rig.responder.heard, {}); };
    const auto bytes = [](const wire::Request& request) {
        return std::vector(request.frame.bytes().begin(), request.frame.bytes().end());
    };
    rig.bus->set_stop({&hold, 1}, clock.now() + 100ms, braked_twice);
    rig.bus->stop();
    EXPECT_EQ(sent(), bytes(hold));
    EXPECT_EQ(rig.bus->stop_results().size(), 1U);
    rig.bus->clear_stop();
    rig.bus->set_stop({&hold, 1}, clock.now() - 1ms, braked_twice);
    rig.bus->stop();
    auto twice = bytes(brake);
    twice.insert(twice.end(), twice.begin(), twice.begin() + brake.frame.size);
    EXPECT_EQ(sent(), twice);
    EXPECT_EQ(rig.bus->stop_results().size(), 2U);
    EXPECT_GT(rig.bus->stop_bound({}).ends, predict_stop(rig.bus->conversation().line(), {}, {&hold, 1}).ends)
        << "of the longer one";
}

TEST(Bus, AnExchangeThatBeginsDoesNotEndAStopThatIsOnItsWay)
{
    JumpingClock clock;
    Rig rig(clock);
    const auto stop = *wire::make_request(3, fake::Set{.value = 0});
    rig.bus->set_stop({&stop, 1});
    const auto read = *wire::make_request(3, fake::Read{});
    Result result;
    rig.bus->start({&read, 1}, {&result, 1});
    Bus* const bus = &*rig.bus;
    ASSERT_FALSE(drive({&bus, 1}, clock.now() + 100us));
    rig.bus->request_stop();
    ASSERT_FALSE(rig.bus->work()) << "the answer that is due goes before";
    Result next;
    rig.bus->start({&read, 1}, {&next, 1});
    EXPECT_EQ(next.error.code, Errc::stopped);
    EXPECT_TRUE(drive({&bus, 1}));
    auto frames = std::vector(read.frame.bytes().begin(), read.frame.bytes().end());
    frames.insert(frames.end(), stop.frame.bytes().begin(), stop.frame.bytes().end());
    EXPECT_EQ(rig.responder.heard, frames);
}

TEST(Bus, ShowsEveryFrameToTheTapWithItsTime)
{
    JumpingClock clock;
    Rig rig(clock);
    std::vector<std::pair<wire::Direction, TimePoint>> seen;
    rig.bus->set_tap([&](const Tapped& t) { seen.emplace_back(t.direction, t.at); });
    ASSERT_TRUE(rig.bus->call(3, fake::Read{}).has_value());
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(seen[0], (std::pair{wire::Direction::request, TimePoint{1s}}));
    EXPECT_EQ(seen[1], (std::pair{wire::Direction::reply, TimePoint{1s + 3ms}}));
}

TEST(Bus, ASlowBusDoesNotHoldUpAFastOne)
{
    JumpingClock clock;
    Rig fast(clock);
    Rig slow(clock);
    slow.responder.delay = 20ms;
    const auto request = *wire::make_request(3, fake::Read{});
    const std::array requests{request, request};
    std::array<Result, 2> of_fast;
    std::array<Result, 2> of_slow;
    fast.bus->start(requests, of_fast);
    slow.bus->start(requests, of_slow);
    Bus* const both[] = {&*fast.bus, &*slow.bus};
    EXPECT_TRUE(drive(both));
    EXPECT_EQ(of_fast[1].at.time_since_epoch(), 1s + 6ms);
    EXPECT_EQ(of_slow[1].at.time_since_epoch(), 1s + 40ms);
}

/// While somebody waits, a stop is asked of a bus from elsewhere; the wait ends at once where it looks for that.
class InterruptingClock final : public JumpingClock
{
public:
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        if (auto* asked = std::exchange(stopped, nullptr))
            asked->request_stop();
        for (const auto& handle : handles)
            if (pollfd ready{.fd = handle.fd, .events = POLLIN, .revents = 0}; ::poll(&ready, 1, 0) > 0)
                return;
        JumpingClock::wait(handles, deadline);
    }
    Bus* stopped = nullptr;
};

TEST(Bus, AStopOfABusWithNothingToDoGoesOutWhileAnotherOneIsWaitedFor)
{
    InterruptingClock clock;
    Rig idle(clock);
    Rig busy(clock);
    const auto stop = *wire::make_request(3, fake::Set{.value = 0});
    idle.bus->set_stop({&stop, 1});
    busy.responder.delay = 20ms;
    const auto request = *wire::make_request(3, fake::Read{});
    Result result;
    busy.bus->start({&request, 1}, {&result, 1});
    Bus* const both[] = {&*idle.bus, &*busy.bus};
    clock.stopped = &*idle.bus;
    EXPECT_TRUE(drive(both));
    ASSERT_EQ(idle.bus->stop_results().size(), 1U);
    EXPECT_EQ(idle.bus->stop_results()[0].sent_at.time_since_epoch(), 1s);
}

/// What each wait looked at.
class LookingClock final : public JumpingClock
{
public:
    void wait(std::span<const link::Handle> handles, TimePoint deadline) override
    {
        seen.assign(handles.begin(), handles.end());
        JumpingClock::wait(handles, deadline);
    }
    std::vector<link::Handle> seen;
};

TEST(Bus, AWaitLooksAtLinkAndStopOfABusyBusAndAtTheStopOfAnIdleOne)
{
    LookingClock clock;
    Rig idle(clock);
    Rig busy(clock);
    const auto request = *wire::make_request(3, fake::Read{});
    Result result;
    busy.bus->start({&request, 1}, {&result, 1});
    Bus* const both[] = {&*idle.bus, &*busy.bus};
    EXPECT_TRUE(drive(both));
    ASSERT_EQ(clock.seen.size(), 3U);
    EXPECT_EQ(clock.seen[0].fd, idle.bus->handles()[1].fd);
    EXPECT_EQ(clock.seen[1].fd, -1) << "a virtual link";
    EXPECT_EQ(clock.seen[2].fd, busy.bus->handles()[1].fd);
    for (const auto& handle : clock.seen)
        EXPECT_FALSE(handle.wants_write) << "that would end the wait at once";
}

TEST(Bus, TheSeventeenthBusThatIsDrivenWakesTheWaitToo)
{
    LookingClock clock;
    std::vector<std::unique_ptr<Rig>> rigs;
    std::vector<Bus*> buses;
    const auto request = *wire::make_request(3, fake::Read{});
    std::array<Result, 17> results;
    for (Result& result : results) {
        rigs.push_back(std::make_unique<Rig>(clock));
        buses.push_back(&*rigs.back()->bus);
        buses.back()->start({&request, 1}, {&result, 1});
    }
    EXPECT_TRUE(drive(buses));
    EXPECT_EQ(clock.seen.size(), 2 * buses.size()) << "link and stop of each";
    EXPECT_EQ(clock.seen.back().fd, buses.back()->handles().back().fd);
    for (const Result& result : results)
        EXPECT_TRUE(result.good);
}

TEST(Bus, DrivesNoLongerThanItIsAllowedTo)
{
    JumpingClock clock;
    Rig rig(clock);
    const auto request = *wire::make_request(3, fake::Read{});
    Result result;
    rig.bus->start({&request, 1}, {&result, 1});
    Bus* const bus = &*rig.bus;
    EXPECT_FALSE(drive({&bus, 1}, clock.now() + 1ms));
    EXPECT_TRUE(drive({&bus, 1}));
    EXPECT_TRUE(result.good);
}

} // namespace
} // namespace sinew::bus
