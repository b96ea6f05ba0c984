#pragma once
#include "sinew/config/robot_file.hpp"
#include "sinew/family/option.hpp"

#include <cstdint>
#include <expected>
#include <limits>
#include <span>
#include <string>
#include <string_view>

/// What goes wrong in a simulated robot: as `[[sim.fault]]` of a robot file, by `sinew sim fault`, or by a program.
namespace sinew::sim {

enum class FaultKind : std::uint8_t {
    flip_bits,     ///< on the wire; `probability` for each byte, on CAN for each frame
    drop_bytes,    ///< likewise
    add_bytes,     ///< likewise
    delay_replies, ///< `probability` for each, by `delay_s`
    duplicate_id,  ///< the joint's device answers to `id`
    unplug,        ///< the joint's device is off its cable, data and power
    power_cut,
    brown_out,  ///< the supply gives `voltage_v`
    stuck_gear, ///< the joint does not turn
    hot_motor,  ///< winding and case are at `temperature_c`, and cool from there
    wrong_baud, ///< the joint's device works at `bit_rate`, whatever its settings say
    push,       ///< `torque_nm` on the joint's shaft, in the device's positive sense
};

struct Fault {
    FaultKind kind = FaultKind::unplug;
    std::string joint;  ///< what it hits: a joint, or
    std::string bus;    ///< a bus, for what happens on wires and supplies
    double at_s = 0.0;  ///< when it begins: of the world's time in a robot file, else from now
    double for_s = 0.0; ///< how long it lasts; 0: until it is taken back
    double probability = 1.0;
    double delay_s = 0.01;
    double voltage_v = 0.0;
    double temperature_c = 80.0;
    double torque_nm = 0.0;
    std::int64_t id = 0;
    std::int64_t bit_rate = 9600;
};

/// What may be written about one kind.
struct FaultKindInfo {
    std::string_view word;
    FaultKind kind;
    bool hits_joint = false;
    bool hits_bus = false;
    std::string_view needs; ///< key that must be given; empty: none
    std::string_view says;
};

std::span<const FaultKindInfo> fault_kinds();
const FaultKindInfo& info_of(FaultKind kind);
/// The keys besides `kind`, `joint` and `bus`.
std::span<const Option<Fault>> fault_options();

/// A fault of a robot file. `bad_file` with its place when a word, a key or a value is wrong. Whether joint and bus
/// exist is looked at as well.
std::expected<Fault, Error> fault_of(const config::RobotFile& file, const config::Section& section);

/// "elbow unplug for_s=2": what it hits, the kind, and key=value for the rest. `bad_argument`; `unknown_name` with the
/// nearest. `file` tells which joints and buses there are.
std::expected<Fault, Error> parse_fault(const config::RobotFile& file, std::span<const std::string> words);

} // namespace sinew::sim
