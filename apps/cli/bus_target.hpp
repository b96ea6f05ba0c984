#pragma once
#include "apps/cli/session.hpp"

/// A whole bus as the command sees it, for the verbs that look at wires and not at devices.
namespace sinew::cli {

struct BusTarget {
    std::string name;               ///< short: of the robot file, or the end of the link
    std::string link;               ///< empty: the robot file gives none
    std::uint32_t bit_rate = 0;     ///< that the robot file or the link says; 0: neither
    const Family* family = nullptr; ///< nullptr: not known
    std::vector<Device> devices;    ///< that should be on it; empty: not known
};

inline constexpr Argument bus_argument{"BUS", "a link, or the name of a bus with --robot"};

/// What BUS and the options `--robot`, `--link`, `--family`, `--id`, `--model` and `--profile` say. A simulated link
/// (`sim:FILE#BUS`) brings its robot file itself. Nothing is opened.
std::expected<BusTarget, Error> bus_target(const Words& words);

/// Looks for the devices of a link where the words name none (`scanning.hpp`), at the bit rate of the link where it
/// says one. `bad_argument` for those of several families.
std::expected<void, Error> find_devices(const Words& words, BusTarget& target);

/// All buses of a robot file that have joints, in the order of the file.
std::expected<std::vector<BusTarget>, Error> buses_of(const std::string& path);

/// The same with the links that they have by the options; those that an empty robot file lacks are a `bad_file`.
std::expected<std::vector<BusTarget>, Error> robot_buses(const Words& words, const std::string& path);

/// "ttyUSB0" of "serial:/dev/ttyUSB0?baud=9600", "left" of "sim:arm.toml#left".
std::string short_name(const std::string& link);

} // namespace sinew::cli
