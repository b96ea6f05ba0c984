#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// The robot file as plain values that remember where they stood. It knows no family: `families.hpp` checks models,
/// profiles, ids and options.
namespace sinew::config {

/// Place of a value in its file, both counted from 1.
struct Mark {
    std::uint32_t line = 0;
    std::uint32_t column = 0;
};

template <class T>
struct Marked {
    T value{};
    Mark at{};
};

/// A key that only a family or the simulator understands: a number, a word or a switch.
struct Setting {
    std::string key;
    std::variant<std::int64_t, double, std::string, bool> value;
    Mark at;
};

/// A table of such keys.
struct Section {
    std::vector<Setting> settings;
    Mark at;
};

struct Bus {
    std::string name;
    Mark at;
    Marked<std::string> family;
    std::optional<Marked<std::string>> link; ///< where the real bus is; the simulator does not need it
    std::optional<Marked<std::int64_t>> bit_rate;
    std::vector<Setting> sim; ///< `[bus.NAME.sim]`: options of the simulated wire and its supply
};

struct Joint {
    std::string name;
    Mark at;
    Marked<std::string> bus;
    Marked<std::int64_t> id;
    std::optional<Marked<std::string>> model;
    std::optional<Marked<std::string>> profile;
    int direction = 1;     ///< +1 or -1
    double zero_rad = 0.0; ///< actuator position at joint position 0
    double ratio = 1.0;    ///< actuator turns per joint turn
    std::optional<double> position_min_rad, position_max_rad, velocity_max_rad_s;
    std::vector<Setting> options; ///< `[joint.NAME.profile_options]`: named options of the profile
    std::vector<Setting> runtime; ///< `[joint.NAME.runtime]`: what its device is set to after every power-on
    std::vector<Setting> sim;     ///< `[joint.NAME.sim]`: options of the simulated device
    std::vector<Setting> plant;   ///< `[joint.NAME.plant]`: of its simulated motor and load
};

struct RobotFile {
    std::string path; ///< as given, for messages
    std::string name;
    std::vector<Bus> buses;
    std::vector<Joint> joints;
    std::vector<Setting> sim;    ///< `[sim]`: options of the simulated world
    std::vector<Section> faults; ///< `[[sim.fault]]`: what goes wrong in it

    const Bus* find_bus(std::string_view bus) const;
    const Joint* find_joint(std::string_view joint) const;
};

/// `bad_file` with "FILE:LINE:COLUMN: what is wrong and what would be right". Unknown keys are errors and suggest the
/// nearest known one.
std::expected<RobotFile, Error> parse_robot_file(std::string_view text, std::string path);

std::expected<RobotFile, Error> read_robot_file(const std::filesystem::path& path);

/// A `bad_file` error at a place of this file.
std::unexpected<Error> fail_at(const RobotFile& file, Mark at, std::string what);

} // namespace sinew::config
