#pragma once
#include "sinew/link/link.hpp"
#include "sinew/sim/virtual_clock.hpp"
#include "sinew/sim/world.hpp"

#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

namespace sinew::sim {

class VirtualPort;

/// A robot inside this program, in virtual time: open its buses, drive them with its clock, and a second passes as fast
/// as the machine computes it, the same every time. Single-threaded. It must outlive the links it opened.
class Simulator
{
public:
    /// `bad_file` as the robot file and its check have it.
    static std::expected<std::unique_ptr<Simulator>, Error> make(const config::RobotFile& file);
    static std::expected<std::unique_ptr<Simulator>, Error> read(const std::filesystem::path& path);
    ~Simulator();

    /// The link of a bus at the bus's bit rate: a `ByteLink` or a `CanLink`. An empty name is the only bus.
    /// `link_not_found`; `link_busy` while another link of that bus is open.
    std::expected<link::AnyLink, Error> open(std::string_view bus);
    /// The host's adapter is pulled out of this program or put back: an open link of the bus hangs up, and none opens
    /// until then. The devices keep their power. False: there is no such bus.
    bool set_plugged(std::string_view bus, bool plugged);
    VirtualClock& clock() { return clock_; }
    World& world() { return *world_; }

private:
    explicit Simulator(std::unique_ptr<World> world);
    std::expected<VirtualPort*, Error> port(std::string_view bus);

    std::unique_ptr<World> world_;
    VirtualClock clock_;
    std::vector<std::unique_ptr<VirtualPort>> ports_;
};

} // namespace sinew::sim
