#include "sinew/base/time.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/family/families.hpp"
#include "sinew/link/links.hpp"
#include "sinew/link/tcp.hpp"
#include "sinew/sim/real_time.hpp"
#include "sinew/sim/simulator.hpp"
#include "tests/support/alarm_clock.hpp"
#include "tests/support/leaks.hpp"
#include "tests/support/random.hpp"

#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <thread>

/// An adapter that is pulled out and put back again and again. SINEW_REPLUGS is how often, SINEW_SEED makes a run
/// again. However often: every call ends, every link comes back, and nothing is left behind.
namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::replugs, test::warm_up, test::Leaks;
namespace fs = std::filesystem;

/// Whether the device answers a request that names it.
std::expected<void, Error> ask(bus::Bus& bus, int id)
{
    const auto request = *bus.protocol().probe(id);
    bus::Result result;
    (void)bus.exchange({&request, 1}, {&result, 1});
    const auto reply = result.reply();
    return reply ? std::expected<void, Error>{} : std::unexpected(reply.error());
}

/// A bus of a simulated robot in virtual time.
struct Simulated {
    explicit Simulated(sim::WorldBus& wire, sim::Simulator& simulated)
        : simulator(simulated), clock(simulated.clock()),
          bus(wire.name, *simulated.open(wire.name), clock, *wire.family->protocol)
    {
        bus.set_reopen([this] { return simulator.open(bus.name()); });
    }
    void plug(bool in) { EXPECT_TRUE(simulator.set_plugged(bus.name(), in)); }
    /// At some moment of an exchange, which lasts so long, or just after it. What is told then, at once.
    std::expected<void, Error> pull_out_amid(Duration exchange, test::Random& random)
    {
        const auto moment = random.below(static_cast<std::uint64_t>(exchange.count()));
        const TimePoint pulled = clock.now() + Duration(moment);
        clock.set(pulled, [this] { plug(false); });
        if (auto told = ask(bus, 1); !told) {
            EXPECT_EQ(clock.now(), pulled);
            return told;
        }
        clock.make_up_for_it();
        return ask(bus, 1);
    }
    void pass(Duration time)
    {
        for (const TimePoint until = clock.now() + time; clock.now() < until;)
            clock.wait({}, until);
    }

    sim::Simulator& simulator;
    test::AlarmClock clock;
    bus::Bus bus;
};

TEST(Replug, OfEveryFamilyInVirtualTimeIsOverWithin200Milliseconds)
{
    test::Random random("replug");
    SCOPED_TRACE(fmt::format("SINEW_SEED={}", test::seed()));
    const auto simulator = *sim::Simulator::read("robots/demo.toml");
    for (sim::WorldBus& wire : simulator->world().buses()) {
        Simulated it(wire, *simulator);
        Duration longest{};
        Leaks leaks(0);
        for (int i = 0; i < replugs() + warm_up; ++i) {
            leaks.round(i);
            const TimePoint asked = it.clock.now();
            ASSERT_TRUE(ask(it.bus, 1).has_value());
            const Duration exchange = it.clock.now() - asked;
            const bool amid = random.one_in(2);
            if (!amid)
                it.plug(false);
            const auto lost = amid ? it.pull_out_amid(exchange, random) : ask(it.bus, 1);
            ASSERT_FALSE(lost.has_value());
            ASSERT_EQ(lost.error().code, Errc::link_lost);
            for (auto gone = random.below(40); gone > 0; --gone) {
                it.pass(10ms);
                ASSERT_EQ(ask(it.bus, 1).error().code, Errc::link_lost);
            }
            it.plug(true);
            const TimePoint back = it.clock.now();
            while (it.bus.link_trouble() != nullptr) {
                it.pass(std::chrono::milliseconds(1 + random.below(20)));
                ASSERT_LE(it.clock.now() - back, 200ms);
                it.bus.tend();
            }
            ASSERT_TRUE(ask(it.bus, 1).has_value());
            longest = std::max(longest, it.clock.now() - back);
        }
        fmt::print("{}: {} times out and back; an answer at the latest {:.1f} ms after the return\n", wire.name,
                   replugs(), seconds(longest) * 1e3);
        EXPECT_LE(longest, 200ms);
        EXPECT_EQ(it.bus.losses(), static_cast<std::uint64_t>(replugs() + warm_up));
    }
}

constexpr std::string_view robot = R"(
version = 1
name = "three"
[bus.arm]
family = "sam"
bit_rate = 1500000
[bus.leg]
family = "rmd"
bit_rate = 1000000
[bus.waist]
family = "nuri"
bit_rate = 115200
[joint.elbow]
bus = "arm"
id = 1
model = "SAM-28"
[joint.knee]
bus = "leg"
id = 1
model = "MG"
profile = "rmd-2.35"
[joint.yaw]
bus = "waist"
id = 1
model = "RSA"
)";

/// A port of this machine that is free now.
std::string free_place()
{
    link::RealClock clock;
    return fmt::format("tcp://127.0.0.1:{}", (*link::TcpListener::open("127.0.0.1", 0, clock))->port());
}

/// A robot behind pseudo terminals and a TCP port, in a thread of its own, that is unplugged as a whole. Each time it
/// comes back its device files have other names, and the symlinks `DIR/BUS` lead to them.
class Pluggable
{
public:
    explicit Pluggable(const config::RobotFile& file) : file_(file)
    {
        std::string name = (fs::temp_directory_path() / "sinew-replug-XXXXXX").string();
        if (::mkdtemp(name.data()) != nullptr)
            folder_ = name;
        plug_in();
    }
    ~Pluggable()
    {
        pull_out();
        fs::remove_all(folder_);
    }

    void plug_in()
    {
        simulator_ = std::move(*sim::RealTimeSimulator::make(file_, clock_, {&place_, 1}));
        stop_ = false;
        thread_ = std::thread([this] { simulator_->run(stop_); });
        for (const auto& link : simulator_->links()) {
            if (link.bus == place_.bus)
                continue;
            const auto device = link::parse_uri(link.uri)->target;
            const fs::path name = folder_ / link.bus;
            EXPECT_FALSE(fs::is_symlink(name) && fs::read_symlink(name) == device) << "it came back as " << device;
            fs::remove(name);
            fs::create_symlink(device, name);
            // While somebody has it open the system gives its name to no other one.
            names_[link.bus] = link::Fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
        }
    }
    void pull_out()
    {
        stop_ = true;
        if (thread_.joinable())
            thread_.join();
        simulator_.reset();
    }
    /// As the simulator prints it, with the name that stays.
    std::string uri(std::size_t index) const
    {
        const auto& link = simulator_->links()[index];
        auto uri = *link::parse_uri(link.uri);
        if (link.bus != place_.bus)
            uri.target = (folder_ / link.bus).string();
        return to_string(uri);
    }

private:
    const config::RobotFile& file_;
    const sim::RealTimeSimulator::Place place_{"waist", free_place()};
    link::RealClock clock_;
    fs::path folder_;
    std::map<std::string, link::Fd> names_; // taken, by bus
    std::unique_ptr<sim::RealTimeSimulator> simulator_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

constexpr Duration patience = 10s; // of a machine that has other work

/// The buses of that robot, over the links of the system.
class Buses
{
public:
    /// Without a period: that which is preset.
    Buses(const Pluggable& devices, bus::Settings settings, std::optional<Duration> period = {})
    {
        constexpr std::array names{"arm", "leg", "waist"};
        constexpr std::array families{"sam", "rmd", "nuri"};
        constexpr std::array schemes{"serial", "slcan", "tcp"};
        const auto links = link::Links::system();
        for (std::size_t i = 0; i < names.size(); ++i) {
            const auto uri = devices.uri(i);
            EXPECT_EQ(link::parse_uri(uri)->scheme, schemes[i]);
            all_.push_back(std::make_unique<bus::Bus>(names[i], *links.open(uri, clock_), clock_,
                                                      *find_family(families[i])->protocol, settings));
            if (period)
                all_.back()->set_reopen(links.reopener(uri, clock_), *period);
            else
                all_.back()->set_reopen(links.reopener(uri, clock_));
        }
    }
    /// Until each has answered once.
    void expect_answers()
    {
        for (const auto& bus : all_)
            EXPECT_TRUE(ask_until(*bus, [](const auto& told) { return told.has_value(); })) << bus->name();
    }
    /// Until each has told that its link is lost. Before, one whose devices are just going may find them silent.
    void expect_losses()
    {
        for (const auto& bus : all_)
            EXPECT_TRUE(ask_until(*bus, [](const auto& told) { return !told && told.error().code == Errc::link_lost; }))
                << bus->name();
    }
    void expect_links()
    {
        for (const auto& bus : all_)
            ASSERT_TRUE(bus->wait_for_link(clock_.now() + patience))
                << bus->name() << ": " << to_sentence(*bus->link_trouble());
    }
    TimePoint now() const { return clock_.now(); }

private:
    template <class Wanted>
    bool ask_until(bus::Bus& bus, Wanted&& wanted)
    {
        const TimePoint end = clock_.now() + patience;
        while (!wanted(ask(bus, 1)))
            if (clock_.now() >= end)
                return false;
        return true;
    }

    link::RealClock clock_;
    std::vector<std::unique_ptr<bus::Bus>> all_;
};

TEST(Replug, OfASerialPortAndAnSlcanAdapterUnderOtherNamesAndOfATcpPortLeavesNothingBehind)
{
    test::Random random("replug of real links");
    SCOPED_TRACE(fmt::format("SINEW_SEED={}", test::seed()));
    const auto file = config::parse_robot_file(robot, "three.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    Pluggable devices(*file);
    // How long a line that is in doubt must be silent; a device that has just started says nothing unasked.
    Buses buses(devices, {.late_max = 1ms}, 1ms);
    Duration longest{};
    Leaks leaks(1);
    for (int i = 0; i < replugs() + warm_up && !testing::Test::HasFailure(); ++i) {
        SCOPED_TRACE(i);
        leaks.round(i);
        buses.expect_answers();
        if (random.one_in(2)) {
            devices.pull_out();
            buses.expect_losses();
        } else { // amid the exchanges that wait for the loss
            const Duration moment(random.below(1'000'000));
            std::thread other([&] {
                link::RealClock clock;
                clock.wait({}, clock.now() + moment);
                devices.pull_out();
            });
            buses.expect_losses();
            other.join();
        }
        devices.plug_in();
        const TimePoint back = buses.now();
        ASSERT_NO_FATAL_FAILURE(buses.expect_links());
        longest = std::max(longest, buses.now() - back);
    }
    fmt::print("{} times out and back; all links open at the latest {:.1f} ms after the return\n", replugs(),
               seconds(longest) * 1e3);
}

/// How long that takes is a matter of the machine too, so it is printed; in virtual time it is asserted, above.
TEST(Replug, OfRealLinksWithTheSettingsThatArePresetEndsWithAnswers)
{
    const auto file = config::parse_robot_file(robot, "three.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    Pluggable devices(*file);
    Buses buses(devices, {});
    std::vector<Duration> took;
    for (int i = 0; i < std::max(5, replugs() / 10) && !testing::Test::HasFailure(); ++i) {
        buses.expect_answers();
        devices.pull_out();
        buses.expect_losses();
        devices.plug_in();
        const TimePoint back = buses.now();
        buses.expect_answers();
        took.push_back(buses.now() - back);
    }
    std::ranges::sort(took);
    fmt::print(
        "{} times out and back with the preset period and late_max; all answer {:.0f} ms after the return, {:.0f} "
        "ms at the latest\n",
        took.size(), seconds(took[took.size() / 2]) * 1e3, seconds(took.back()) * 1e3);
}

} // namespace
} // namespace sinew
