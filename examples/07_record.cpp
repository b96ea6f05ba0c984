#include "sinew/record/recorder.hpp"
#include "sinew/robot/guardian.hpp"
#include "sinew/robot/robot.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>
#include <filesystem>

using namespace sinew;
using namespace std::chrono_literals;

// What the robot did, in a file that any MCAP viewer opens: `sinew plot`, `sinew export`, Foxglove.
int main(int argc, char** argv)
{
    const auto path =
        argc > 1 ? std::filesystem::path(argv[1]) : std::filesystem::temp_directory_path() / "07_record.mcap";
    // Stops the motors when this program dies, by Ctrl-C too, or hangs for a second.
    auto guardian = robot::Guardian::start({.patience = 1s});
    if (!guardian)
        return std::puts(to_sentence(guardian.error()).c_str()), 1;
    sim::Worlds worlds;
    link::RealClock real;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    const auto clock = sim::clock_for("sim:robots/demo.toml", real, worlds); // for hardware: &real, and no `simulated`
    auto robot = robot::Robot::open("robots/demo.toml", links, **clock, {.simulated = true, .guardian = &*guardian});
    if (!robot)
        return std::puts(to_sentence(robot.error()).c_str()), 1;
    auto recorder = record::Recorder::create(path, {});
    if (!recorder)
        return std::puts(to_sentence(recorder.error()).c_str()), 1;

    std::vector<record::Recorder::Joint> names;
    for (const auto& joint : robot->joints())
        names.push_back((*recorder)->add_joint({.name = joint.name(), .bus = joint.bus()}));
    for (bus::Bus* bus : robot->buses()) {
        const auto name = (*recorder)->add_bus({.name = bus->name()});
        bus->set_tap([&, name](const bus::Tapped& tapped) { (*recorder)->frame(name, tapped); });
    }
    if (const auto on = robot->enable(); !on)
        return std::puts(to_sentence(on.error()).c_str()), 1;
    if (const auto set =
            robot->set("elbow", {.mode = robot::Mode::position, .position_rad = 0.5, .velocity_rad_s = 0.5});
        !set)
        return std::puts(to_sentence(set.error()).c_str()), 1;
    const auto ended = robot->run(
        10ms,
        [&](robot::Robot& all) {
            for (std::size_t i = 0; i < names.size(); ++i) {
                (*recorder)->state(names[i], all.joints()[i].state());
                (*recorder)->command(names[i], all.clock().now(), all.joints()[i].command());
            }
            (void)(*recorder)->drain(); // with hardware: run_in_thread(), for a robot must not wait for a disk
        },
        (*clock)->now() + 1s);
    robot->stop();
    const auto written = (*recorder)->finish();
    std::printf("%llu messages in %s\n", static_cast<unsigned long long>((*recorder)->messages()), path.c_str());
    return ended && written ? 0 : 1;
}
