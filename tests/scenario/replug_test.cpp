#include "sinew/base/time.hpp"
#include "sinew/bus/bus.hpp"
#include "sinew/family/families.hpp"
#include "sinew/link/links.hpp"
#include "sinew/link/tcp.hpp"
#include "sinew/sim/real_time.hpp"
#include "sinew/sim/simulator.hpp"
#include "tests/support/random.hpp"

#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <map>
#include <thread>

/// An adapter that is pulled out and put back again and again. SINEW_REPLUGS is how often, SINEW_SEED makes a run
/// again. However often: every call ends, every link comes back, and nothing is left behind.
namespace sinew {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr int warm_up = 10;

int replugs()
{
    return static_cast<int>(test::setting("SINEW_REPLUGS", 100));
}

/// What this program holds: descriptors, and bytes of the heap (0 under a sanitizer, which looks for leaks itself).
struct Held {
    std::ptrdiff_t descriptors = 0;
    std::size_t heap = 0;
    static Held now() { return {std::distance(fs::directory_iterator{"/proc/self/fd"}, {}), ::mallinfo2().uordblks}; }
};

/// After `warm_up` rounds there are as many descriptors as at the end, and no more of the heap than a sentence or two
/// that got longer. A connection that the other thread is just about to take or to close may be counted or not:
/// `in_passing` of them; a leak would be one a round.
class Leaks
{
public:
    explicit Leaks(std::ptrdiff_t in_passing) : in_passing_(in_passing) {}
    void round(int number)
    {
        if (number == warm_up)
            before_ = Held::now();
    }
    ~Leaks()
    {
        const Held after = Held::now();
        EXPECT_LE(std::abs(after.descriptors - before_.descriptors), in_passing_);
        EXPECT_LE(after.heap, before_.heap + 4096);
        fmt::print("{} descriptors before and {} after, {} bytes of heap before and {} after\n", before_.descriptors,
                   after.descriptors, before_.heap, after.heap);
    }

private:
    std::ptrdiff_t in_passing_;
    Held before_ = Held::now();
};

/// Whether the device answers a request that names it.
std::expected<void, Error> ask(bus::Bus& bus, int id)
{
    const auto request = *bus.protocol().probe(id);
    bus::Result result;
    (void)bus.exchange({&request, 1}, {&result, 1});
    const auto reply = result.reply();
    return reply ? std::expected<void, Error>{} : std::unexpected(reply.error());
}

TEST(Replug, OfEveryFamilyInVirtualTimeIsOverWithin200Milliseconds)
{
    test::Random random("replug");
    SCOPED_TRACE(fmt::format("SINEW_SEED={}", test::seed()));
    const auto simulator = *sim::Simulator::read("robots/demo.toml");
    sim::VirtualClock& clock = simulator->clock();
    for (sim::WorldBus& wire : simulator->world().buses()) {
        bus::Bus bus(wire.name, *simulator->open(wire.name), clock, *wire.family->protocol);
        bus.set_reopen([&] { return simulator->open(wire.name); });
        Duration longest{};
        Leaks leaks(0);
        for (int i = 0; i < replugs() + warm_up; ++i) {
            leaks.round(i);
            ASSERT_TRUE(ask(bus, 1).has_value());
            simulator->set_plugged(wire.name, false);
            const auto lost = ask(bus, 1);
            ASSERT_FALSE(lost.has_value());
            ASSERT_EQ(lost.error().code, Errc::link_lost);
            const auto pass = [&](Duration time) {
                for (const TimePoint until = clock.now() + time; clock.now() < until;)
                    clock.wait({}, until);
            };
            for (auto gone = random.below(40); gone > 0; --gone) {
                pass(10ms);
                ASSERT_EQ(ask(bus, 1).error().code, Errc::link_lost);
            }
            simulator->set_plugged(wire.name, true);
            const TimePoint back = clock.now();
            while (bus.link_trouble() != nullptr) {
                pass(std::chrono::milliseconds(1 + random.below(20)));
                ASSERT_LE(clock.now() - back, 200ms);
                bus.tend();
            }
            ASSERT_TRUE(ask(bus, 1).has_value());
            longest = std::max(longest, clock.now() - back);
        }
        fmt::print("{}: {} times out and back; an answer at the latest {:.1f} ms after the return\n", wire.name,
                   replugs(), seconds(longest) * 1e3);
        EXPECT_EQ(bus.losses(), static_cast<std::uint64_t>(replugs() + warm_up));
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

TEST(Replug, OfASerialPortAndAnSlcanAdapterUnderOtherNamesAndOfATcpPortLeavesNothingBehind)
{
    const auto file = config::parse_robot_file(robot, "three.toml");
    ASSERT_TRUE(file) << to_sentence(file.error());
    Pluggable devices(*file);
    constexpr std::array schemes{"serial", "slcan", "tcp"};
    for (std::size_t i = 0; i < schemes.size(); ++i)
        ASSERT_EQ(link::parse_uri(devices.uri(i))->scheme, schemes[i]);
    link::RealClock clock;
    const auto links = link::Links::system();
    // How long a line that is in doubt must be silent; a device that has just started says nothing unasked.
    constexpr bus::Settings settings{.late_max = 1ms};
    bus::Bus arm("arm", *links.open(devices.uri(0), clock), clock, *find_family("sam")->protocol, settings);
    bus::Bus leg("leg", *links.open(devices.uri(1), clock), clock, *find_family("rmd")->protocol, settings);
    bus::Bus waist("waist", *links.open(devices.uri(2), clock), clock, *find_family("nuri")->protocol, settings);
    const std::array all{&arm, &leg, &waist};
    arm.set_reopen(links.reopener(devices.uri(0), clock), 1ms);
    leg.set_reopen(links.reopener(devices.uri(1), clock), 1ms);
    waist.set_reopen(links.reopener(devices.uri(2), clock), 1ms);
    constexpr Duration patience = 10s; // of a machine that has other work
    Duration longest{};
    Leaks leaks(1);
    for (int i = 0; i < replugs() + warm_up; ++i) {
        leaks.round(i);
        for (bus::Bus* bus : all)
            ASSERT_TRUE(ask(*bus, 1).has_value()) << bus->name() << " " << i;
        devices.pull_out();
        for (bus::Bus* bus : all)
            ASSERT_EQ(ask(*bus, 1).error().code, Errc::link_lost) << bus->name() << " " << i;
        devices.plug_in();
        const TimePoint back = clock.now();
        for (bus::Bus* bus : all)
            ASSERT_TRUE(bus->wait_for_link(clock.now() + patience))
                << bus->name() << " " << i << ": " << to_sentence(*bus->link_trouble());
        longest = std::max(longest, clock.now() - back);
    }
    fmt::print("{} times out and back; all links open at the latest {:.1f} ms after the return\n", replugs(),
               seconds(longest) * 1e3);
}

} // namespace
} // namespace sinew
