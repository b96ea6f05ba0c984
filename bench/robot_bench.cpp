#include "sinew/robot/robot.hpp"
#include "sinew/sim/simulator.hpp"

#include <algorithm>
#include <ctime>
#include <fmt/core.h>
#include <map>
#include <memory>
#include <vector>

/// robot_bench [ROUNDS]: what the robot layer (plans, limits, supervision, states) adds to the exchanges of a cycle, of
/// the demo robot at 100 Hz, which its slow bus does not reach, and of 16 motors on six CAN buses at 1 kHz.
/// The same requests go out on the same simulated buses once by `Robot::cycle` and once by `bus::drive` alone; the
/// difference is the layer. CPU time of this process; medians over the rounds with the spread.
namespace {

using namespace sinew;
using namespace std::chrono_literals;

constexpr int cycles = 400;
constexpr int joint_count = 16;

/// As many buses as can carry them once in a millisecond.
std::string sixteen_motors()
{
    constexpr int buses = 6;
    std::string text = "version = 1\nname = \"sixteen\"\n";
    for (int i = 0; i < buses; ++i)
        text += fmt::format("[bus.can{}]\nfamily = \"rmd\"\nbit_rate = 1000000\n", i);
    for (int i = 0; i < joint_count; ++i)
        text += fmt::format("[joint.joint{}]\nbus = \"can{}\"\nid = {}\nmodel = \"MG\"\n", i, i % buses, 1 + i / buses);
    return text;
}

double cpu_us()
{
    timespec t{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

template <class T>
T must(std::expected<T, Error> value)
{
    if (!value) {
        fmt::print(stderr, "robot_bench: {}\n", to_sentence(value.error()));
        std::exit(1);
    }
    return std::move(*value);
}

void must(const std::expected<void, Error>& done)
{
    if (!done) {
        fmt::print(stderr, "robot_bench: {}\n", to_sentence(done.error()));
        std::exit(1);
    }
}

struct Rig {
    explicit Rig(const config::RobotFile& file)
        : simulator(must(sim::Simulator::make(file))), robot(must(open(file, *simulator)))
    {
        must(robot.enable());
    }
    static std::expected<robot::Robot, Error> open(const config::RobotFile& file, sim::Simulator& simulator)
    {
        link::Links links;
        links.add({.name = "sim",
                   .open = [&simulator](const link::Uri& uri, link::Clock&) { return simulator.open(uri.fragment); }});
        return robot::Robot::open(file, links, simulator.clock(), {.simulated = true});
    }
    void wait(TimePoint until)
    {
        while (simulator->clock().now() < until)
            simulator->clock().wait({}, until);
    }
    TimePoint now() { return simulator->clock().now(); }

    std::unique_ptr<sim::Simulator> simulator;
    robot::Robot robot;
};

/// The requests of each bus in each cycle, as the tap shows them.
using Recording = std::vector<std::map<std::string, std::vector<wire::Request>>>;

wire::Request request_of(const robot::Robot& /*robot*/, std::span<robot::Joint> joints, const bus::Bus& bus,
                         const bus::Tapped& tapped)
{
    wire::Frame frame{.can_id = tapped.can_id, .size = static_cast<std::uint8_t>(tapped.bytes.size())};
    std::ranges::copy(tapped.bytes, frame.data.begin());
    const int id = bus.protocol().addressee(frame);
    for (const auto& joint : joints)
        if (joint.bus() == bus.name() && id_of(joint.device()) == id) {
            const auto* message = bus.protocol().identify(frame, wire::Direction::request, line_of(joint.device()));
            return {.id = id,
                    .message = message,
                    .frame = frame,
                    .options = options_of(joint.device()),
                    .answered = answers(joint.device(), *message),
                    .response_time = response_time_of(joint.device())};
        }
    return {};
}

/// One second of commands; how much a cycle took.
double drive_robot(Rig& rig, Duration period, Recording* recording)
{
    const double before = cpu_us();
    for (int i = 0; i < cycles; ++i) {
        const TimePoint next = rig.now() + period;
        if (recording != nullptr)
            recording->emplace_back();
        must(rig.robot.cycle());
        rig.wait(next);
    }
    return (cpu_us() - before) / cycles;
}

double drive_buses(Rig& rig, Duration period, const Recording& recording)
{
    std::vector<bus::Result> results(512);
    const double before = cpu_us();
    for (const auto& requests : recording) {
        const TimePoint next = rig.now() + period;
        std::size_t at = 0;
        for (bus::Bus* bus : rig.robot.buses()) {
            const auto& own = requests.at(bus->name());
            bus->start(own, std::span(results).subspan(at, own.size()));
            at += own.size();
        }
        bus::drive(rig.robot.buses());
        rig.wait(next);
    }
    return (cpu_us() - before) / static_cast<double>(recording.size());
}

std::string spread(std::vector<double> all)
{
    std::ranges::sort(all);
    return fmt::format("{:7.2f} ({:.2f}-{:.2f})", all[all.size() / 2], all.front(), all.back());
}

void measure(std::string_view what, const config::RobotFile& file, Duration period, int rounds)
{
    Recording recording;
    {
        Rig rig(file);
        for (bus::Bus* bus : rig.robot.buses())
            bus->set_tap([&, bus](const bus::Tapped& tapped) {
                if (!recording.empty() && tapped.verdict == bus::Verdict::sent)
                    recording.back()[bus->name()].push_back(request_of(rig.robot, rig.robot.joints(), *bus, tapped));
            });
        (void)drive_robot(rig, period, &recording);
    }
    std::size_t requests = 0;
    for (const auto& cycle : recording)
        for (const auto& [bus, own] : cycle)
            requests += own.size();
    std::vector<double> robot, buses, again, layer, noise;
    for (int round = 0; round < rounds; ++round) {
        Rig one(file), two(file), three(file);
        buses.push_back(drive_buses(one, period, recording));
        robot.push_back(drive_robot(two, period, nullptr));
        again.push_back(drive_buses(three, period, recording));
        layer.push_back((robot.back() - (buses.back() + again.back()) / 2.0) / joint_count);
        noise.push_back((again.back() - buses.back()) / joint_count);
    }
    fmt::print(
        "\n{}, a cycle of 16 joints in the simulator ({:.1f} requests), {} rounds: median (least-most), us of CPU\n",
        what, static_cast<double>(requests) / cycles, rounds);
    fmt::print("  exchanges alone               {}\n", spread(buses));
    fmt::print("  the same again                {}\n", spread(again));
    fmt::print("  Robot::cycle                  {}\n", spread(robot));
    fmt::print("  the robot layer, a joint      {}   floor {}\n", spread(layer), spread(noise));
}

} // namespace

int main(int argc, char** argv)
{
    const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 15;
    measure("the demo robot at 100 Hz", must(config::read_robot_file("robots/demo.toml")), 10ms, rounds);
    measure("16 motors on six CAN buses at 1 kHz", must(config::parse_robot_file(sixteen_motors(), "sixteen")), 1ms,
            rounds);
    return 0;
}
