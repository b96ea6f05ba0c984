#pragma once
#include "sinew/link/links.hpp"
#include "sinew/sim/simulator.hpp"

#include <map>
#include <memory>
#include <string>

namespace sinew::sim {

/// The simulated robots of a program, one for each robot file: whoever opens two buses of one file gets two buses of
/// one world, with one time. It owns worlds, their clocks, and the threads of those that run in real time, so it must
/// outlive all links that were opened through it. Single-threaded.
class Worlds
{
public:
    Worlds();
    ~Worlds();
    Worlds(const Worlds&) = delete;
    Worlds& operator=(const Worlds&) = delete;

    /// The world of a robot file in virtual time, made at the first call. Two paths to one file are one world.
    std::expected<Simulator*, Error> simulator(const std::string& path);

    /// Opens a bus of `sim:FILE#BUS`. In virtual time the clock must be that of the world, else `bad_argument`. With
    /// `clock=real` the world runs in a thread of its own behind pseudo terminals, and any real clock will do.
    std::expected<link::AnyLink, Error> open(const link::Uri& uri, link::Clock& clock);

private:
    class Running;

    std::expected<Running*, Error> running(const std::string& path);

    std::map<std::string, std::unique_ptr<Simulator>> simulators_;
    std::map<std::string, std::unique_ptr<Running>> running_;
};

/// Whether a link is one of these, in whatever time.
bool is_simulated(std::string_view uri);

/// Adds the scheme `sim:FILE#BUS` (one bus: `#BUS` may be left out). The worlds must outlive the links.
void add(link::Links& links, Worlds& worlds);

struct Opened {
    link::Clock* clock = nullptr; ///< that must drive the link: the world's, or the real one that was given
    link::AnyLink link;
};

/// Opens any link with the clock that it needs. `links` has had `add` with these worlds.
std::expected<Opened, Error> open(const link::Links& links, link::Clock& real, std::string_view uri, Worlds& worlds);

/// The clock that `uri` needs: that of its world for `sim:` in virtual time, `real` for all others.
std::expected<link::Clock*, Error> clock_for(std::string_view uri, link::Clock& real, Worlds& worlds);

} // namespace sinew::sim
