#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/session.hpp"
#include "apps/cli/sim_control.hpp"
#include "apps/cli/sim_flash.hpp"
#include "apps/cli/terminal.hpp"
#include "apps/cli/verb.hpp"
#include "sinew/sim/real_time.hpp"

#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>

namespace sinew::cli {
namespace {

std::atomic<bool> stop{false};

extern "C" void on_stop(int)
{
    stop.store(true);
}

void stop_on_signals()
{
    struct sigaction action{};
    action.sa_handler = on_stop;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGHUP, &action, nullptr);
}

constexpr const char* demo = "robots/demo.toml";

std::expected<std::string, Error> robot_file(const Words& words)
{
    if (const auto given = words.text("ROBOT"))
        return *given;
    if (std::filesystem::exists(demo))
        return std::string(demo);
    return fail(Errc::bad_argument, fmt::format("which robot? Name its file, such as sinew sim {}", demo));
}

void print_links(std::span<const sim::RealTimeSimulator::BusLink> links, bool json)
{
    if (json) {
        Json out = Json::array();
        for (const auto& link : links)
            out.add(Json::object({{"bus", link.bus}, {"family", link.family}, {"link", link.uri}}));
        print_line(out);
        return;
    }
    std::size_t longest_name = 0;
    std::size_t longest_family = 0;
    for (const auto& link : links) {
        longest_name = std::max(longest_name, width(link.bus));
        longest_family = std::max(longest_family, width(link.family));
    }
    for (const auto& link : links)
        fmt::print("{}{}  {:<{}}  {}\n", link.bus, std::string(longest_name - width(link.bus), ' '), link.family,
                   longest_family, link.uri);
    std::fflush(stdout);
}

Outcome run(const Words& words)
{
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    const auto path = robot_file(words);
    if (!path)
        return std::unexpected(path.error());
    const auto file = robot_file_at(*path);
    if (!file)
        return std::unexpected(file.error());
    const auto links = given_links(words, *file);
    if (!links)
        return std::unexpected(links.error());
    std::vector<sim::RealTimeSimulator::Place> places;
    for (const auto& [bus, link] : *links)
        places.push_back({bus, link});
    link::RealClock clock;
    const auto simulator = sim::RealTimeSimulator::make(*file, clock, places);
    if (!simulator)
        return std::unexpected(simulator.error());
    stop_on_signals();
    const bool prompt = stdout_is_terminal() && ::isatty(STDIN_FILENO) == 1;
    const auto control = SimControl::open(**simulator, prompt, [] { stop.store(true); });
    if (!control)
        return std::unexpected(control.error());
    std::unique_ptr<SimFlash> flash;
    if (const auto given = words.text("--flash")) {
        auto opened = SimFlash::open(*given, (*simulator)->world(), **control);
        if (!opened)
            return std::unexpected(opened.error());
        flash = std::move(*opened);
    }
    // Whoever reads the links may ask at once: it listens already.
    print_links((*simulator)->links(), words.json());
    if (prompt)
        fmt::print(stderr, "Running until Ctrl-C. From another terminal: sinew scan LINK\n"
                           "Here: Enter shows the devices, help what else there is.\n");
    (*control)->show_prompt();
    const TimePoint until = *time ? clock.now() + **time : TimePoint::max();
    (*simulator)->run(stop, until, flash ? static_cast<sim::Visitor*>(flash.get()) : control->get());
    if (flash)
        if (const auto kept = flash->close(); !kept)
            return std::unexpected(kept.error());
    return exit_done;
}

} // namespace

Verb sim_verb()
{
    return {.name = "sim",
            .says = "Run a simulated robot as if it were there; prints a line per bus: name, family and link.",
            .arguments = {{"ROBOT", "its robot file; robots/demo.toml where that exists", false}},
            .options = {{"--link", "BUS=LINK",
                         "reach this bus by tcp://ADDRESS:PORT (serial) or can:INTERFACE (CAN) instead of a pseudo "
                         "terminal",
                         true},
                        {"--for", "TIME", "end after this time, such as 10s; otherwise it runs until Ctrl-C"},
                        {"--flash", "FILE", "keep in this file what the devices keep without power, from run to run"},
                        {"--json", "", "print the buses as one line of JSON"}},
            .examples = {{"sinew sim", "the demo robot, until Ctrl-C"},
                         {"sinew sim arm.toml --for 10s", "for a test"},
                         {"sinew sim arm.toml --link left=tcp://127.0.0.1:4001 --link legs=can:vcan0",
                          "behind a TCP port and on a CAN interface"}},
            .run = run,
            .more =
                "On a terminal it has a prompt: Enter shows what each device is doing, help lists the rest. Another "
                "process asks it by sinew sim look, sim fault and sim mend."};
}

} // namespace sinew::cli
