#pragma once
#include "sinew/base/error.hpp"
#include "sinew/config/mark.hpp"
#include "sinew/config/motion.hpp"

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

/// `[bus.NAME.realtime]`: what the thread that drives a bus asks of the operating system.
struct RealTime {
    bool lock_memory = false;
    std::optional<Marked<std::int64_t>> priority;  ///< 1 … 99, of SCHED_FIFO
    std::optional<Marked<std::int64_t>> processor; ///< counted from 0
};

/// What becomes of a joint when nobody may command it any more.
enum class Policy : std::uint8_t { hold, release, brake };
std::string_view to_word(Policy policy);

/// `[safety]`: what holds for every joint that says nothing else.
struct Safety {
    Policy policy = Policy::hold;
    bool whole_robot = true; ///< `on_fault`: a fault of one joint stops all; false: that joint alone
    std::optional<double> command_timeout_s;
    std::optional<double> temperature_max_c, current_max_a, step_max_rad;
    double silence_max_s = 0.5; ///< so long a joint may give no answer
    double stop_time_s = 0.1;   ///< in which a joint surely comes to rest after it was told to hold
};

/// `[joint.NAME.home]`: how a joint finds and reaches its position 0.
struct Home {
    bool to_stop = false;                 ///< `routine = "stop"`: first turns until something stops it
    int direction = -1;                   ///< in which the stop lies
    double position_rad = 0.0;            ///< of the stop
    double velocity_rad_s = 0.1;          ///< of the routine and of the way to 0
    std::optional<double> travel_max_rad; ///< so far it looks for its stop
};

struct Bus {
    std::string name;
    Mark at;
    Marked<std::string> family;
    std::optional<Marked<std::string>> link; ///< where the real bus is; the simulator does not need it
    std::optional<Marked<std::int64_t>> bit_rate;
    std::optional<double> rate_hz; ///< of its cycles; not given: as the loop asks
    RealTime realtime;
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
    std::optional<double> current_max_a, torque_max_nm, step_max_rad, temperature_max_c, stop_time_s;
    Home home;
    std::optional<double> acceleration_max_rad_s2, jerk_max_rad_s3; ///< of poses, sequences and synchronised moves
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
    Safety safety;
    std::vector<Pose> poses;
    std::vector<Sequence> sequences;
    std::vector<Setting> sim;    ///< `[sim]`: options of the simulated world
    std::vector<Section> faults; ///< `[[sim.fault]]`: what goes wrong in it

    const Bus* find_bus(std::string_view bus) const;
    const Joint* find_joint(std::string_view joint) const;
    const Pose* find_pose(std::string_view pose) const;
    const Sequence* find_sequence(std::string_view sequence) const;
};

/// `bad_file` with "FILE:LINE:COLUMN: what is wrong and what would be right". Unknown keys are errors and suggest the
/// nearest known one.
std::expected<RobotFile, Error> parse_robot_file(std::string_view text, std::string path);

std::expected<RobotFile, Error> read_robot_file(const std::filesystem::path& path);

/// A `bad_file` error at a place of this file.
std::unexpected<Error> fail_at(const RobotFile& file, Mark at, std::string what);

} // namespace sinew::config
