#pragma once
#include "sinew/actuator/actuator.hpp"
#include "sinew/bus/tap.hpp"
#include "sinew/record/captured.hpp"
#include "sinew/record/json.hpp"
#include "sinew/record/mcap_reader.hpp"

/// What sinew puts into MCAP files. All messages are JSON with a schema; names and units are those of the library.
///
/// | topic                 | schema               | metadata of the channel                |
/// |-----------------------|----------------------|----------------------------------------|
/// | `/bus/NAME`           | `sinew.Frame`        | bus, family, kind (bytes, can), bit_rate |
/// | `/joint/NAME/state`   | `sinew.JointState`   | joint, bus, family, model, id          |
/// | `/joint/NAME/command` | `sinew.JointCommand` | the same                               |
/// | `/events`             | `sinew.Event`        |                                        |
///
/// The robot file is the attachment `robot_attachment`. The time of a message is when it passed or was measured: time
/// of day, or of a bus in virtual time since its power-on (metadata `sinew`, key `time`: `utc` or `virtual`).
namespace sinew::record {

inline constexpr std::string_view robot_attachment = "robot.toml";

enum class Topic : std::uint8_t { frame, state, command, event, other };

/// A key of a message as people know it.
struct Column {
    std::string_view name; ///< with its unit
    std::string_view type; ///< of JSON
    std::string_view says;
};

std::span<const Column> columns_of(Topic topic);
std::string_view schema_name(Topic topic);
mcap::Schema schema_of(Topic topic);
/// What a channel holds, by its schema.
Topic topic_of(const mcap::Reader& reader, const mcap::Channel& channel);

struct BusInfo {
    std::string name;
    std::string family; ///< empty: not known
    bool can = false;
    std::uint32_t bit_rate = 0; ///< 0: not known
};
struct JointInfo {
    std::string name;
    std::string bus;
    std::string family;
    std::string model;
    int id = -1;
};

mcap::Channel channel_of(const BusInfo& bus);
mcap::Channel channel_of(const JointInfo& joint, Topic topic);
mcap::Channel event_channel();

// ---- messages ----

void put_frame(std::string& out, const bus::Tapped& tapped, bool can);
void put_frame(std::string& out, const Captured& captured);
/// When each value was told last: a value is told once, in the message of the look that has measured it.
struct Told {
    TimePoint position{TimePoint::min()}, velocity = position, current = position, voltage = position,
                                          temperature = position, faults = position, enabled = position;
};
/// False, and nothing appended, when nothing in it is new.
bool put_state(std::string& out, const actuator::State& state, Told& told);
void put_command(std::string& out, const actuator::Command& command);

/// "none", or what is wrong, separated by commas.
std::string faults_text(actuator::Faults faults, std::uint32_t raw);

/// A message of a bus. `bad_file` where it cannot be one.
std::expected<Captured, Error> frame_from(const mcap::Message& message);

} // namespace sinew::record
