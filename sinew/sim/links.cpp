#include "sinew/sim/links.hpp"

#include "sinew/sim/real_time.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <thread>

namespace sinew::sim {
namespace {

/// Two ways to write one file are one key. A file that is not there keeps its name: reading it says so.
std::string key_of(const std::string& path)
{
    std::error_code none;
    const auto canonical = std::filesystem::weakly_canonical(path, none);
    return none ? path : canonical.string();
}

std::expected<bool, Error> is_virtual(const link::Uri& uri)
{
    const auto clock = uri.option("clock").value_or("virtual");
    if (clock != "virtual" && clock != "real")
        return fail(Errc::bad_uri, fmt::format("clock={} in '{}': it is virtual or real", clock, to_string(uri)));
    return clock == "virtual";
}

} // namespace

/// A world in real time with the thread that runs it.
class Worlds::Running
{
public:
    static std::expected<std::unique_ptr<Running>, Error> start(const std::string& path)
    {
        const auto file = config::read_robot_file(path);
        if (!file)
            return std::unexpected(file.error());
        auto running = std::make_unique<Running>();
        auto simulator = RealTimeSimulator::make(*file, running->clock_);
        if (!simulator)
            return std::unexpected(std::move(simulator.error()));
        running->simulator_ = std::move(*simulator);
        running->thread_ = std::thread([&r = *running] { r.simulator_->run(r.stop_); });
        return running;
    }
    ~Running()
    {
        stop_ = true;
        if (thread_.joinable())
            thread_.join();
    }

    /// The link's own name: the pseudo terminal. An empty bus is the only one.
    std::expected<std::string, Error> uri_of(std::string_view bus)
    {
        const auto found = simulator_->world().find_bus(bus);
        if (!found)
            return std::unexpected(found.error());
        return simulator_->links()[static_cast<std::size_t>(*found - simulator_->world().buses().data())].uri;
    }

private:
    link::RealClock clock_;
    std::unique_ptr<RealTimeSimulator> simulator_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

Worlds::Worlds() = default;
Worlds::~Worlds() = default;

std::expected<Simulator*, Error> Worlds::simulator(const std::string& path)
{
    auto& known = simulators_[key_of(path)];
    if (!known) {
        auto made = Simulator::read(path);
        if (!made)
            return std::unexpected(std::move(made.error()));
        known = std::move(*made);
    }
    return known.get();
}

std::expected<Worlds::Running*, Error> Worlds::running(const std::string& path)
{
    auto& known = running_[key_of(path)];
    if (!known) {
        auto started = Running::start(path);
        if (!started)
            return std::unexpected(std::move(started.error()));
        known = std::move(*started);
    }
    return known.get();
}

std::expected<link::AnyLink, Error> Worlds::open(const link::Uri& uri, link::Clock& clock)
{
    const auto in_virtual_time = is_virtual(uri);
    if (!in_virtual_time)
        return std::unexpected(in_virtual_time.error());
    if (!*in_virtual_time) {
        const auto world = running(uri.target);
        if (!world)
            return std::unexpected(world.error());
        const auto pty = (*world)->uri_of(uri.fragment);
        return pty ? link::Links::system().open(*pty, clock) : std::unexpected(pty.error());
    }
    const auto world = simulator(uri.target);
    if (!world)
        return std::unexpected(world.error());
    if (&clock != &(*world)->clock())
        return fail(Errc::bad_argument,
                    fmt::format("'{}' has a time of its own and cannot be opened with another clock; open it alone, or "
                                "write clock=real",
                                to_string(uri)));
    return (*world)->open(uri.fragment);
}

bool is_simulated(std::string_view uri)
{
    const auto parsed = link::parse_uri(uri);
    return parsed && parsed->scheme == "sim";
}

void add(link::Links& links, Worlds& worlds)
{
    links.add({.name = "sim",
               .form = "sim:FILE#BUS",
               .says = "A simulated bus of a robot file inside this program; clock=real for real time.",
               .options = {"clock"},
               .open = [&worlds](const link::Uri& uri, link::Clock& clock) { return worlds.open(uri, clock); }});
}

std::expected<link::Clock*, Error> clock_for(std::string_view uri, link::Clock& real, Worlds& worlds)
{
    const auto parsed = link::parse_uri(uri);
    if (!parsed)
        return std::unexpected(parsed.error());
    if (parsed->scheme != "sim")
        return &real;
    const auto in_virtual_time = is_virtual(*parsed);
    if (!in_virtual_time)
        return std::unexpected(in_virtual_time.error());
    if (!*in_virtual_time)
        return &real;
    const auto world = worlds.simulator(parsed->target);
    if (!world)
        return std::unexpected(world.error());
    return &(*world)->clock();
}

std::expected<Opened, Error> open(const link::Links& links, link::Clock& real, std::string_view uri, Worlds& worlds)
{
    const auto clock = clock_for(uri, real, worlds);
    if (!clock)
        return std::unexpected(clock.error());
    auto link = links.open(uri, **clock);
    if (!link)
        return std::unexpected(std::move(link.error()));
    return Opened{*clock, std::move(*link)};
}

} // namespace sinew::sim
