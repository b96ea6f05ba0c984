#pragma once
#include "sinew/family/families.hpp"
#include "sinew/family/option.hpp"
#include "sinew/sim/plant/plant.hpp"

#include <cstdint>
#include <expected>
#include <span>

/// What a robot file may say about the simulated world besides its devices.
namespace sinew::sim {

/// `[sim]`.
struct WorldOptions {
    std::int64_t seed = 1; ///< of all that happens by chance
};

/// What becomes of a byte that two talk at once.
enum class Collision : std::uint8_t {
    by_wire,   ///< open drain on two lines, garbled on one pair
    garble,    ///< GUESS for RS-485: bits that they disagree about are anything
    wired_and, ///< open drain: a 0 wins
};

/// `[bus.NAME.sim]`.
struct BusOptions {
    double supply_v = 0.0;    ///< of all devices; 0: each has the voltage that it is made for
    double supply_ohm = 0.05; ///< ASSUMED: of cable and power supply
    bool echo = false;        ///< the adapter hears what it sends (serial buses)
    bool half_duplex = false; ///< a SAM bus on one RS-485 pair, which the encoder class has; Nuri always is
    Collision collision = Collision::by_wire;
    double usb_latency_s = 0.0; ///< how long the adapter keeps what it has heard (serial buses); often 0.001 or 0.016
};

std::span<const Option<WorldOptions>> world_options();
std::span<const Option<BusOptions>> bus_options();
/// `[joint.NAME.plant]`: every field of `PlantParameters`, instead of what the ratings of the device give.
std::span<const Option<PlantParameters>> plant_options();

std::expected<WorldOptions, Error> world_options_of(const config::RobotFile& file);
std::expected<BusOptions, Error> bus_options_of(const config::RobotFile& file, const config::Bus& bus);
/// Whether a joint may hang on a bus that is `half_duplex` (L172).
std::expected<void, Error> check_half_duplex(const config::RobotFile& file, const ResolvedJoint& joint);
/// `derived` with what the file says about this joint's plant. `bad_file` when it makes no sense.
std::expected<PlantParameters, Error> plant_of(const config::RobotFile& file, const config::Joint& joint,
                                               const PlantParameters& derived);

} // namespace sinew::sim
