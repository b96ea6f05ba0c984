#include "apps/cli/forecast.hpp"

#include "sinew/base/units.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include "sinew/sim/simulator.hpp"
#include "tests/support/alarm_clock.hpp"
#include "tests/support/asking.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <set>

namespace sinew::cli {
namespace {

/// The demo robot with one of its buses only.
config::RobotFile only(std::string_view bus)
{
    auto file = *config::read_robot_file("robots/demo.toml");
    std::erase_if(file.buses, [&](const auto& one) { return one.name != bus; });
    std::erase_if(file.joints, [&](const auto& one) { return one.bus.value != bus; });
    file.poses.clear();
    file.sequences.clear();
    return file;
}

/// How long a cycle of a robot takes whose joints are all sent to another place in each. Now and then there is more in
/// a cycle, and less in none, so it is the one in the middle.
double cycle_s(const config::RobotFile& file)
{
    sim::Worlds worlds;
    link::Links links;
    sim::add(links, worlds);
    link::RealClock real;
    const std::string uri = fmt::format("sim:{}#{}", file.path, file.buses.front().name);
    link::Clock* const clock = *sim::clock_for(uri, real, worlds);
    auto robot = robot::Robot::open(file, links, *clock, {.simulated = true});
    if (!robot || !robot->enable())
        return 0.0;
    std::vector<double> took;
    for (int i = 0; i < 201; ++i) {
        const TimePoint begun = clock->now();
        for (auto& joint : robot->joints()) {
            const double to = units::rad(0.01 * i);
            static_cast<void>(joint.set({.mode = robot::Mode::position, .position_rad = joint.nearest_step_rad(to)}));
        }
        if (!robot->cycle())
            return 0.0;
        took.push_back(seconds(clock->now() - begun));
    }
    std::ranges::sort(took);
    return took[took.size() / 2];
}

TEST(Forecast, ACycleOfARobotTakesWhatThePlanSaysWithinTwoPercent)
{
    const auto buses = buses_of("robots/demo.toml");
    ASSERT_TRUE(buses);
    ASSERT_EQ(buses->size(), 3U);
    for (const auto& bus : *buses) {
        const auto plan = forecast(*bus.family, bus.devices, bus.bit_rate);
        const double rate = 1.0 / cycle_s(only(bus.name));
        const double least = cycles_per_s(plan, plan.cycle, bus::Stuffing::most);
        const double most = cycles_per_s(plan, plan.cycle, bus::Stuffing::least);
        fmt::print("{}: planned {:.1f} to {:.1f}, measured {:.1f} cycles a second\n", bus.name, least, most, rate);
        EXPECT_GE(rate, least * 0.98) << bus.name;
        EXPECT_LE(rate, most * 1.02) << bus.name;
    }
}

// ---- the serial line to an SLCAN adapter ----

/// The legs of the demo robot behind such an adapter.
Forecast behind_slcan(const std::string& options)
{
    auto buses = *buses_of("robots/demo.toml");
    auto& legs = *std::ranges::find(buses, "legs", &BusTarget::name);
    for (auto& device : legs.devices)
        device.link = "slcan:/dev/ttyUSB0" + options;
    return forecast(*legs.family, legs.devices, legs.bit_rate);
}

TEST(Forecast, OfAnSlcanAdapterOnASlowSerialLineIsNoMoreThanThatCarries)
{
    const auto usb = behind_slcan(""), slow = behind_slcan("?baud=115200"), fast = behind_slcan("?baud=12000000");
    const auto rate = [](const Forecast& plan, bus::Stuffing stuffing) {
        return cycles_per_s(plan, plan.look, stuffing);
    };
    EXPECT_EQ(rate(usb, bus::Stuffing::most), rate(fast, bus::Stuffing::most)) << "there CAN is what limits it";
    // 22 characters of ten bits for each of the questions, and as many and two for its answer.
    const auto frames = static_cast<double>(slow.look.size());
    EXPECT_NEAR(rate(slow, bus::Stuffing::most), 115'200.0 / (frames * 24 * 10), 1e-3);
    EXPECT_EQ(rate(slow, bus::Stuffing::most), rate(slow, bus::Stuffing::least)) << "text has no stuff bits";
    EXPECT_LT(rate(slow, bus::Stuffing::most), rate(usb, bus::Stuffing::most) / 5);
    EXPECT_EQ(bottleneck(slow, slow.cycle).by, Bottleneck::By::port);
    EXPECT_NE(bottleneck(usb, usb.cycle).by, Bottleneck::By::port);
}

TEST(Forecast, OfAStopBehindAnSlcanAdapterWaitsForTheTextBeforeIt)
{
    const auto usb = stop_bound(behind_slcan("")), slow = stop_bound(behind_slcan("?baud=115200"));
    // Six motors, one question of each outstanding with its answer, before the frames of the stop with theirs.
    const double character_s = 10.0 / 115'200;
    EXPECT_NEAR(seconds(slow.begins - usb.begins), (6 * (22 + 24) + 22) * character_s, 1e-6);
    EXPECT_NEAR(seconds(slow.ends - usb.ends),
                (6 + static_cast<double>(behind_slcan("").stop.size())) * (22 + 24) * character_s, 1e-6);
}

TEST(BusTarget, BehindAnSlcanAdapterHasTheRateOfCanAndNotThatOfThePort)
{
    Words words;
    words.add("BUS", "slcan:/dev/ttyUSB0?baud=115200&bitrate=500000");
    EXPECT_EQ(bus_target(words)->bit_rate, 500'000U);
}

// ---- the stop ----

/// Of one bus, counted from what caused its stop: when its first frame went out, when everybody had heard the
/// broadcast where there is one, and when all its joints were told.
bus::StopBound measured(const bus::Bus& bus, std::span<const wire::Request> stop, TimePoint caused)
{
    const auto results = bus.stop_results();
    TimePoint begins = TimePoint::max(), ends{};
    for (const auto& result : results) {
        begins = std::min(begins, result.sent_at);
        ends = std::max(ends, result.at);
    }
    const TimePoint first = stop.front().answered ? begins : results.front().at;
    return {.begins = begins - caused, .first = first - caused, .ends = ends - caused};
}

/// The demo robot with a policy, at full load in virtual time: each bus cycles as often as its wire allows, and all
/// joints are sent to another place all the time.
class Loaded
{
public:
    static constexpr Duration period = std::chrono::microseconds(50);

    explicit Loaded(const std::string& path)
        : simulator_(*sim::Simulator::read(path)), clock_(simulator_->clock()), buses_(*buses_of(path)),
          robot_(open(path))
    {
        for (std::size_t bus = 0; bus < buses_.size(); ++bus)
            bounds_.push_back(stop_bound(plan(bus)));
    }

    /// Does it so long after the robot was enabled, whatever is on the wires then, and waits until the robot has
    /// stopped. How long each bus took.
    std::vector<bus::StopBound> stop_after(Duration time, const std::function<void()>& cause)
    {
        EXPECT_TRUE(robot_.enable());
        const TimePoint begun = clock_.now();
        TimePoint caused{};
        clock_.set(begun + time, [&] {
            caused = clock_.now();
            cause();
        });
        const auto ran = robot_.run(period, [&](robot::Robot& all) {
            for (auto& joint : all.joints()) {
                const double to = units::rad(20.0) * seconds(clock_.now() - begun);
                (void)joint.set({.mode = robot::Mode::position, .position_rad = joint.nearest_step_rad(to)});
            }
        });
        EXPECT_FALSE(ran) << "it has stopped";
        std::vector<bus::StopBound> out;
        for (std::size_t bus = 0; bus < buses_.size(); ++bus)
            out.push_back(measured(*robot_.buses()[bus], robot_.stop_requests(bus), caused));
        return out;
    }

    robot::Robot& robot() { return robot_; }
    sim::Simulator& simulator() { return *simulator_; }
    std::span<const BusTarget> buses() const { return buses_; }
    Forecast plan(std::size_t bus) const
    {
        const auto& one = buses_[bus];
        return forecast(*one.family, one.devices, one.bit_rate);
    }
    const bus::StopBound& bound(std::size_t bus) const { return bounds_[bus]; }

private:
    robot::Robot open(const std::string& path)
    {
        link::Links links;
        links.add({.name = "sim",
                   .form = "sim:FILE#BUS",
                   .says = "A bus of this test.",
                   .options = {},
                   .open = [this](const link::Uri& uri, link::Clock&) { return simulator_->open(uri.fragment); }});
        return *robot::Robot::open(path, links, clock_, {.simulated = true});
    }

    std::unique_ptr<sim::Simulator> simulator_;
    test::AlarmClock clock_;
    std::vector<BusTarget> buses_;
    robot::Robot robot_;
    std::vector<bus::StopBound> bounds_;
};

/// A program stops at each of so many moments, spread over what a robot reads now and then.
constexpr int moments = 97;
constexpr Duration moment(int i)
{
    return std::chrono::milliseconds(20) + i * std::chrono::microseconds(1350);
}

class StopOfALoadedRobot : public testing::TestWithParam<std::string>
{
protected:
    void SetUp() override
    {
        path_ = testing::TempDir() + "sinew-policy-" + GetParam() + ".toml";
        std::ifstream demo("robots/demo.toml");
        std::ofstream(path_) << demo.rdbuf() << "\n[safety]\npolicy = \"" << GetParam() << "\"\n";
    }
    void TearDown() override { std::filesystem::remove(path_); }

    std::string path_;
};

void expect_within(const bus::StopBound& took, const bus::StopBound& planned, const std::string& when)
{
    EXPECT_LE(took.begins, planned.begins) << when;
    EXPECT_LE(took.first, planned.first) << when;
    EXPECT_LE(took.ends, planned.ends) << when;
}

/// `asker` asks for the stop while the buses are driven.
void expect_the_plan_to_hold(Loaded& loaded, void (*asker)(const test::Ask&), const std::string& policy)
{
    std::vector<Duration> worst(loaded.buses().size());
    for (int i = 0; i < moments; ++i) {
        const auto took = loaded.stop_after(moment(i), [&] { asker([&] { loaded.robot().request_stop(); }); });
        for (std::size_t bus = 0; bus < took.size(); ++bus) {
            expect_within(took[bus], loaded.bound(bus), fmt::format("{} at moment {}", loaded.buses()[bus].name, i));
            worst[bus] = std::max(worst[bus], took[bus].ends);
        }
    }
    for (std::size_t bus = 0; bus < worst.size(); ++bus) {
        const Duration planned = loaded.bound(bus).ends;
        fmt::print("{} {}: {:.2f} ms at worst, planned {:.2f} ms\n", policy, loaded.buses()[bus].name,
                   seconds(worst[bus]) * 1e3, seconds(planned) * 1e3);
        EXPECT_GT(worst[bus], planned / 3) << "a bound that is never nearly reached says little";
    }
}

TEST_P(StopOfALoadedRobot, FromAnotherThreadIsNeverLaterThanThePlanSays)
{
    Loaded loaded(path_);
    expect_the_plan_to_hold(loaded, test::ask_from_another_thread, GetParam());
}

TEST_P(StopOfALoadedRobot, FromASignalHandlerIsNeverLaterThanThePlanSays)
{
    Loaded loaded(path_);
    expect_the_plan_to_hold(loaded, test::ask_from_a_signal_handler, GetParam());
}

TEST_P(StopOfALoadedRobot, FromAnotherBusThatLosesItsLinkIsNeverLaterThanThePlanSays)
{
    Loaded loaded(path_);
    for (int i = 0; i < moments; ++i) {
        const std::size_t lost = static_cast<std::size_t>(i) % loaded.buses().size();
        const auto& name = loaded.buses()[lost].name;
        const auto took =
            loaded.stop_after(moment(i), [&] { EXPECT_TRUE(loaded.simulator().set_plugged(name, false)); });
        for (std::size_t bus = 0; bus < took.size(); ++bus)
            if (bus != lost)
                expect_within(took[bus], loaded.bound(bus),
                              fmt::format("{} at moment {}", loaded.buses()[bus].name, i));
        EXPECT_TRUE(loaded.simulator().set_plugged(name, true));
    }
}

TEST_P(StopOfALoadedRobot, WaitsForNoExchangeThatThePlanDoesNotKnow)
{
    std::ofstream(path_, std::ios::app) << "[joint.elbow.runtime]\np_gain = 77\nd_gain = 5\n"
                                           "[joint.left_hip.runtime]\nacceleration_deg_s2 = 500\n";
    Loaded loaded(path_);
    const TimePoint after_enabling = loaded.simulator().clock().now() + moment(0);
    std::vector<std::set<std::string_view>> sent(loaded.buses().size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
        auto* const bus = loaded.robot().buses()[i];
        bus->set_tap([&, bus, i](const bus::Tapped& tapped) {
            wire::Frame frame{.can_id = tapped.can_id, .size = static_cast<std::uint8_t>(tapped.bytes.size())};
            std::ranges::copy(tapped.bytes, frame.data.begin());
            const auto& line = loaded.buses()[i].devices.front().line();
            const auto* message = bus->protocol().identify(frame, wire::Direction::request, line);
            if (tapped.direction == wire::Direction::request && tapped.at > after_enabling && message != nullptr)
                sent[i].insert(message->name());
        });
    }
    // Long enough for everything that is read now and then, and for a device that forgets what it was set to.
    const auto cause = [&] { loaded.robot().request_stop(); };
    loaded.simulator().world().inject(
        {.kind = sim::FaultKind::power_cut, .joint = "left_hip", .at_s = 1.0, .for_s = 0.1});
    loaded.stop_after(std::chrono::seconds(3), cause);
    for (std::size_t i = 0; i < sent.size(); ++i) {
        std::set<std::string_view> known;
        const auto plan = loaded.plan(i);
        for (const auto* steps : {&plan.most, &plan.stop})
            for (const auto& step : *steps)
                known.insert(step.request.message->name());
        EXPECT_GT(sent[i].size(), 3U);
        for (const auto name : sent[i])
            EXPECT_TRUE(known.contains(name)) << loaded.buses()[i].name << " carried " << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Forecast, StopOfALoadedRobot, testing::Values("hold", "release", "brake"),
                         [](const auto& one) { return one.param; });

} // namespace
} // namespace sinew::cli
