#include "tests/bus/rig.hpp"
#include "tests/support/asking.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <thread>
#include <unistd.h>

namespace sinew::tests {
namespace {

using namespace std::chrono_literals;

/// Why a bus stops.
class Cause
{
public:
    virtual ~Cause() = default;
    /// Before the bus begins; whom to drive beside it, if anybody.
    virtual bus::Bus* prepare(bus::Bus&) { return nullptr; }
    virtual void happen(bus::Bus& bus) = 0;
};
using MakeCause = std::unique_ptr<Cause> (*)(WireClock&);

template <void (*Asker)(const test::Ask&)>
std::unique_ptr<Cause> asked(WireClock&)
{
    struct Asked final : Cause {
        void happen(bus::Bus& bus) override
        {
            Asker([&] { bus.request_stop(); });
        }
    };
    return std::make_unique<Asked>();
}

/// Another bus, which waits for an answer, loses its link.
class LossBeside final : public Cause
{
public:
    explicit LossBeside(WireClock& clock) : failing_(clock, nuri::protocol(), 9'600)
    {
        failing_.bus->set_reopen([this] { return failing_.plug_in(); }, Duration(1));
    }
    bus::Bus* prepare(bus::Bus& bus) override
    {
        failing_.bus->stop_when_lost({&bus});
        failing_.bus->start({&ping_, 1}, {&result_, 1});
        return &*failing_.bus;
    }
    void happen(bus::Bus&) override { failing_.unplug_host(); }

private:
    SerialRig failing_;
    wire::Request ping_ = *wire::make_request(1, nuri::RequestPing{});
    bus::Result result_;
};

std::unique_ptr<Cause> loss_beside(WireClock& clock)
{
    return std::make_unique<LossBeside>(clock);
}

/// A bus at full load, and when its devices heard the stop.
template <class Rig, class Read>
struct Load {
    Rig& rig;
    std::vector<wire::Request> cycle{};
    std::vector<bus::Result> results{};
    std::vector<wire::Request> stop{};
    std::vector<TimePoint> heard{}; // stop requests by the devices, in order

    void add(int id, Duration response, const std::function<bool(const wire::Frame&)>& is_stop,
             const std::function<std::optional<wire::Frame>(const wire::Frame&)>& answer)
    {
        rig.add(id, [=, this](const wire::Frame& request, TimePoint at) -> std::optional<sim::Answer> {
            if (is_stop(request))
                heard.push_back(at);
            const auto frame = answer(request);
            return frame ? std::optional(sim::Answer{*frame, response}) : std::nullopt;
        });
        cycle.push_back(*wire::make_request(id, Read{}, {}, response));
    }

    /// The bus is stopped at so many moments of a cycle, evenly spread; checks the bound at each.
    void stop_at_every_moment(WireClock& clock, std::size_t expected, Cause& cause)
    {
        Alarm alarm(clock);
        bus::Bus& bus = *rig.bus;
        bus.set_stop(stop);
        results.resize(cycle.size());
        const bus::StopBound bound = bus.stop_bound(cycle);
        const Duration whole = bus::predict_cycle(bus.conversation().line(), cycle);
        constexpr int moments = 97;
        Duration worst{};
        for (int i = 0; i < moments; ++i) {
            heard.clear();
            // The one that is stopped stands first, so that its turn is over when the other fails.
            const std::array both{&bus, cause.prepare(bus)};
            const auto driven = std::span(both).first(both[1] == nullptr ? 1 : 2);
            TimePoint asked{};
            alarm.set(clock.now() + whole * i / moments, [&] {
                asked = clock.now();
                cause.happen(bus);
            });
            bus.start(cycle, results);
            bus::drive(driven);
            alarm.make_up_for_it();
            bus::drive(driven);
            const TimePoint carried_out = clock.now();
            clock.wait({}, carried_out + 5ms); // whatever is still on the wire
            ASSERT_EQ(heard.size(), expected) << "at moment " << i;
            EXPECT_LE(heard.front() - asked, bound.first);
            EXPECT_LE(heard.back() - asked, bound.ends);
            EXPECT_LE(carried_out - asked, bound.ends);
            worst = std::max(worst, heard.front() - asked);
            for (const auto& result : results)
                EXPECT_TRUE(result.good || result.error.code == Errc::stopped);
            EXPECT_EQ(bus.exchange(cycle, results).has_value(), true);
            EXPECT_EQ(results[0].error.code, Errc::stopped) << "until clear_stop";
            bus.clear_stop();
            clock.wait({}, clock.now() + 200ms);
            bool all_good = bus.exchange(cycle, results).has_value();
            for (const auto& result : results)
                all_good = all_good && result.good;
            EXPECT_TRUE(all_good) << "after clear_stop";
        }
        EXPECT_GT(worst, bound.first / 2) << "a bound that is never nearly reached says little";
    }
};

void stop_sams(MakeCause make_cause)
{
    WireClock clock;
    const auto cause = make_cause(clock);
    SerialRig rig(clock, sam::protocol(), 1'500'000);
    Load<SerialRig, sam::QuickReadStatus> load{rig};
    const auto brake_all = *wire::make_request(31, sam::QuickBrakeMode{});
    for (int id = 0; id < 8; ++id) {
        const auto brake = *wire::make_request(id, sam::QuickBrakeMode{}, {}, 50us);
        load.add(
            id, 50us, [=](const wire::Frame& f) { return f == brake_all.frame || f == brake.frame; },
            [=](const wire::Frame& f) -> std::optional<wire::Frame> {
                if (f == brake_all.frame)
                    return std::nullopt;
                const auto byte = static_cast<std::uint8_t>(id);
                if (f == brake.frame)
                    return *wire::encode_reply<sam::QuickBrakeMode>(id, {.id = byte, .position = 9});
                return *wire::encode_reply<sam::QuickReadStatus>(id, {.load = 1, .position = byte});
            });
        load.stop.push_back(brake);
    }
    load.stop.insert(load.stop.begin(), brake_all);
    load.stop.front().answered = false;
    load.stop_at_every_moment(clock, 8 + 8, *cause);
    for (const auto& result : rig.bus->stop_results().subspan(1))
        EXPECT_TRUE(result.good) << "each device's own word: " << to_sentence(result.error);
}

void stop_nuris(MakeCause make_cause)
{
    WireClock clock;
    const auto cause = make_cause(clock);
    SerialRig rig(clock, nuri::protocol(), 1'000'000);
    Load<SerialRig, nuri::RequestPositionFeedback> load{rig};
    const auto off_all = *wire::make_request(255, nuri::SetControlOnOff{.control = nuri::Control::off});
    for (int id = 0; id < 8; ++id) {
        const auto off = *wire::make_request(id, nuri::SetControlOnOff{.control = nuri::Control::off});
        load.add(
            id, 100us, [=](const wire::Frame& f) { return f == off_all.frame || f == off.frame; },
            [=](const wire::Frame& f) -> std::optional<wire::Frame> {
                if (f == off_all.frame || f == off.frame)
                    return std::nullopt;
                return *wire::encode_reply<nuri::RequestPositionFeedback>(id, {.position = 4711});
            });
        load.stop.push_back(off);
    }
    load.stop.insert(load.stop.begin(), off_all);
    load.stop_at_every_moment(clock, 8 + 8, *cause);
}

void stop_rmds(MakeCause make_cause)
{
    WireClock clock;
    const auto cause = make_cause(clock);
    CanRig rig(clock, 1'000'000);
    Load<CanRig, rmd::ReadStatus2> load{rig};
    for (int id = 1; id <= 8; ++id) {
        const auto stop = *wire::make_request(id, rmd::MotorStop{}, {}, 100us);
        load.add(
            id, 100us, [=](const wire::Frame& f) { return f == stop.frame; },
            [=](const wire::Frame& f) -> std::optional<wire::Frame> {
                if (f == stop.frame)
                    return *wire::encode_reply<rmd::MotorStop>(id, {});
                return *wire::encode_reply<rmd::ReadStatus2>(id, {.temperature = 30, .speed = 300});
            });
        load.stop.push_back(stop);
    }
    load.stop_at_every_moment(clock, 8, *cause);
}

TEST(Stop, ReachesSamServosWithinTheBoundAtEveryMoment)
{
    stop_sams(asked<test::ask_here>);
}

TEST(Stop, ReachesNuriServosWithinTheBoundAtEveryMoment)
{
    stop_nuris(asked<test::ask_here>);
}

TEST(Stop, ReachesRmdMotorsWithinTheBoundAtEveryMoment)
{
    stop_rmds(asked<test::ask_here>);
}

TEST(Stop, FromAnotherThreadReachesServosUnderFullLoadWithinTheBoundAtEveryMoment)
{
    stop_sams(asked<test::ask_from_another_thread>);
    stop_nuris(asked<test::ask_from_another_thread>);
    stop_rmds(asked<test::ask_from_another_thread>);
}

TEST(Stop, FromASignalHandlerReachesServosUnderFullLoadWithinTheBoundAtEveryMoment)
{
    stop_sams(asked<test::ask_from_a_signal_handler>);
    stop_nuris(asked<test::ask_from_a_signal_handler>);
    stop_rmds(asked<test::ask_from_a_signal_handler>);
}

TEST(Stop, OfAnotherBusThatLosesItsLinkReachesServosUnderFullLoadWithinTheBoundAtEveryMoment)
{
    stop_sams(loss_beside);
    stop_nuris(loss_beside);
    stop_rmds(loss_beside);
}

/// A link of the operating system on which nothing ever comes, and what was written to it.
class SilentLink final : public link::ByteLink
{
public:
    ~SilentLink() override { ::close(fd_); }
    std::expected<std::size_t, Error> write(std::span<const std::uint8_t> bytes) override
    {
        written.insert(written.end(), bytes.begin(), bytes.end());
        return bytes.size();
    }
    std::expected<link::Arrival, Error> read(std::span<std::uint8_t>) override { return link::Arrival{}; }
    int handle() const override { return fd_; }
    link::LinkState state() const override { return {.open = true, .bit_rate = 1'000'000}; }
    std::expected<std::uint32_t, Error> set_bit_rate(std::uint32_t bit_rate) override { return bit_rate; }

    std::vector<std::uint8_t> written;

private:
    int fd_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
};

/// A bus in real time that waits for an answer for an hour.
struct Patient {
    Patient()
    {
        auto made = std::make_unique<SilentLink>();
        link = made.get();
        bus.emplace("patient", link::AnyLink{std::unique_ptr<link::ByteLink>{std::move(made)}}, clock, nuri::protocol(),
                    bus::Settings{.margin_at_first = 1h, .margin_most = 1h});
        bus->set_stop({&stop, 1});
    }
    link::RealClock clock;
    SilentLink* link = nullptr;
    std::optional<bus::Bus> bus;
    wire::Request stop = *wire::make_request(255, nuri::SetControlOnOff{.control = nuri::Control::off});
};

/// The stop frame is the last that went out.
void expect_stopped(const Patient& patient, const std::expected<nuri::ReplyPing, Error>& reply)
{
    ASSERT_FALSE(reply.has_value());
    EXPECT_EQ(reply.error().code, Errc::stopped);
    const auto stop = patient.stop.frame.bytes();
    ASSERT_GE(patient.link->written.size(), stop.size());
    EXPECT_TRUE(std::ranges::equal(std::span(patient.link->written).last(stop.size()), stop));
}

TEST(Stop, ComesFromAnotherThread)
{
    Patient patient;
    std::thread other([&] { patient.bus->request_stop(); });
    const auto reply = patient.bus->call(1, nuri::RequestPing{});
    other.join();
    expect_stopped(patient, reply);
}

TEST(Stop, ComesFromASignalHandler)
{
    Patient patient;
    const test::Ask ask = [&] { patient.bus->request_stop(); };
    const test::InSignalHandler handler(ask);
    const pthread_t waits = pthread_self();
    std::thread other([&] { pthread_kill(waits, SIGUSR1); });
    const auto reply = patient.bus->call(1, nuri::RequestPing{});
    other.join();
    expect_stopped(patient, reply);
}

TEST(Stop, IsCarriedOutByTheCallerWhenNobodyDrives)
{
    Patient patient;
    patient.bus->stop();
    EXPECT_TRUE(std::ranges::equal(patient.link->written, patient.stop.frame.bytes()));
    EXPECT_TRUE(patient.bus->stop_results()[0].good);
}

} // namespace
} // namespace sinew::tests
