#include "sinew/record/topics.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::record {
namespace {

using actuator::Fault;
using wire::Direction;

constexpr Column frame_columns[] = {
    {"direction", "string", "request: sent by the host; reply: by a device; not there: not known"},
    {"verdict", "string", "what the host made of it: sent, taken, stray, late, bad_checksum, echo, quarantined"},
    {"discarded", "string", "why the host threw it away"},
    {"kind", "string", "can_remote or can_error; not there: data"},
    {"can_id", "integer", "identifier of a CAN frame"},
    {"extended", "boolean", "the identifier has 29 bits"},
    {"size", "integer", "length that a remote request asks for"},
    {"bytes", "string", "what it carries, in hex"},
};
constexpr Column state_columns[] = {
    {"position_rad", "number", "measured position"},
    {"velocity_rad_s", "number", "measured velocity"},
    {"current_a", "number", "current of the motor"},
    {"voltage_v", "number", "voltage of the supply"},
    {"temperature_c", "number", "temperature"},
    {"faults", "string", "none, or what is wrong"},
    {"enabled", "boolean", "whether the device drives its motor"},
};
constexpr Column command_columns[] = {
    {"mode", "string", "hold, release, brake, position, velocity, current, torque or duty"},
    {"position_rad", "number", "where to"},
    {"velocity_rad_s", "number", "how fast, or no faster than"},
    {"current_a", "number", "with how much, or no more than"},
    {"torque_nm", "number", "with how much"},
    {"duty", "number", "share of the supply, -1 to 1"},
    {"duration_s", "number", "arrive after"},
    {"resolution_rad", "number", "as coarse as this will do"},
};
constexpr Column event_columns[] = {
    {"level", "string", "info, warning or error"},
    {"name", "string", "what happened, one word"},
    {"text", "string", "one sentence"},
};

constexpr std::array<std::string_view, 4> names{"sinew.Frame", "sinew.JointState", "sinew.JointCommand", "sinew.Event"};
constexpr std::array<std::string_view, 4> titles{"A CAN frame, or bytes of a serial line",
                                                 "What was measured; each value in the message in which it was new",
                                                 "What a joint was told", "Something that happened"};

template <class T>
bool is_new(const actuator::Measured<T>& measured, TimePoint& told)
{
    if (!measured || measured.at() <= told)
        return false;
    told = measured.at();
    return true;
}

void put_optional(JsonWriter& json, std::string_view key, const std::optional<double>& value)
{
    if (value)
        json.number(key, *value);
}

std::string_view to_word(Direction direction)
{
    return direction == Direction::request ? "request" : "reply";
}

} // namespace

std::span<const Column> columns_of(Topic topic)
{
    switch (topic) {
    case Topic::frame:
        return frame_columns;
    case Topic::state:
        return state_columns;
    case Topic::command:
        return command_columns;
    case Topic::event:
        return event_columns;
    case Topic::other:
        break;
    }
    return {};
}

std::string_view schema_name(Topic topic)
{
    return topic == Topic::other ? std::string_view{} : names[static_cast<std::size_t>(topic)];
}

mcap::Schema schema_of(Topic topic)
{
    std::string properties;
    for (const auto& column : columns_of(topic))
        properties += fmt::format("{}\"{}\":{{\"type\":\"{}\",\"description\":\"{}\"}}", properties.empty() ? "" : ",",
                                  column.name, column.type, column.says);
    return {.name = std::string(schema_name(topic)),
            .encoding = "jsonschema",
            .data = fmt::format("{{\"title\":\"{}\",\"description\":\"{}\",\"type\":\"object\",\"properties\":{{{}}}}}",
                                schema_name(topic), titles[static_cast<std::size_t>(topic)], properties)};
}

Topic topic_of(const mcap::Reader& reader, const mcap::Channel& channel)
{
    const auto* schema = reader.schema(channel.schema_id);
    const auto found = schema == nullptr ? names.end() : std::ranges::find(names, schema->name);
    return found == names.end() || channel.message_encoding != "json" ? Topic::other
                                                                      : static_cast<Topic>(found - names.begin());
}

mcap::Channel channel_of(const BusInfo& bus)
{
    mcap::Channel out{.topic = "/bus/" + bus.name, .message_encoding = "json"};
    out.metadata = {{"bus", bus.name}, {"family", bus.family}, {"kind", bus.can ? "can" : "bytes"}};
    if (bus.bit_rate != 0)
        out.metadata.emplace_back("bit_rate", std::to_string(bus.bit_rate));
    return out;
}

mcap::Channel channel_of(const JointInfo& joint, Topic topic)
{
    return {.topic = fmt::format("/joint/{}/{}", joint.name, topic == Topic::state ? "state" : "command"),
            .message_encoding = "json",
            .metadata = {{"joint", joint.name},
                         {"bus", joint.bus},
                         {"family", joint.family},
                         {"model", joint.model},
                         {"id", std::to_string(joint.id)}}};
}

mcap::Channel event_channel()
{
    return {.topic = "/events", .message_encoding = "json"};
}

void put_frame(std::string& out, const bus::Tapped& tapped, bool can)
{
    JsonWriter json(out);
    json.text("direction", to_word(tapped.direction));
    json.text("verdict", bus::to_word(tapped.verdict));
    if (can)
        json.whole("can_id", tapped.can_id);
    json.hex("bytes", tapped.bytes);
}

void put_frame(std::string& out, const Captured& captured)
{
    JsonWriter json(out);
    if (captured.direction)
        json.text("direction", to_word(*captured.direction));
    if (!captured.discarded.empty())
        json.text("discarded", captured.discarded);
    if (captured.kind == Captured::Kind::can_remote)
        json.text("kind", "can_remote");
    if (captured.kind == Captured::Kind::can_error)
        json.text("kind", "can_error");
    if (captured.is_can())
        json.whole("can_id", captured.frame.can_id);
    if (captured.extended)
        json.flag("extended", true);
    if (captured.kind == Captured::Kind::can_remote)
        json.whole("size", captured.frame.size);
    json.hex("bytes", captured.data());
}

std::string faults_text(actuator::Faults faults, std::uint32_t raw)
{
    std::string out;
    for (unsigned bit = 1; bit <= static_cast<unsigned>(Fault::unexplained); bit <<= 1U) {
        const auto fault = static_cast<Fault>(bit);
        if (!faults.has(fault))
            continue;
        out += out.empty() ? "" : ", ";
        out += to_word(fault);
        if (fault == Fault::unexplained)
            out += fmt::format(" 0x{:X}", raw);
    }
    return out.empty() ? "none" : out;
}

bool put_state(std::string& out, const actuator::State& state, Told& told)
{
    const std::size_t start = out.size();
    {
        JsonWriter json(out);
        const auto add = [&](std::string_view key, const actuator::Measured<double>& value, TimePoint& at) {
            if (is_new(value, at))
                json.number(key, *value);
        };
        add("position_rad", state.position_rad, told.position);
        add("velocity_rad_s", state.velocity_rad_s, told.velocity);
        add("current_a", state.current_a, told.current);
        add("voltage_v", state.voltage_v, told.voltage);
        add("temperature_c", state.temperature_c, told.temperature);
        if (is_new(state.faults, told.faults)) {
            if (state.faults->any())
                json.text("faults", faults_text(*state.faults, state.raw_faults));
            else
                json.text("faults", "none");
        }
        if (is_new(state.enabled, told.enabled))
            json.flag("enabled", *state.enabled);
    }
    constexpr std::size_t empty_object = 2;
    if (out.size() - start > empty_object)
        return true;
    out.resize(start);
    return false;
}

void put_command(std::string& out, const actuator::Command& command)
{
    JsonWriter json(out);
    json.text("mode", to_word(command.mode));
    put_optional(json, "position_rad", command.position_rad);
    put_optional(json, "velocity_rad_s", command.velocity_rad_s);
    put_optional(json, "current_a", command.current_a);
    put_optional(json, "torque_nm", command.torque_nm);
    put_optional(json, "duty", command.duty);
    if (command.duration)
        json.number("duration_s", seconds(*command.duration));
    put_optional(json, "resolution_rad", command.resolution_rad);
}

std::expected<Captured, Error> frame_from(const mcap::Message& message)
{
    const auto refused = [](std::string_view why) { return fail(Errc::bad_file, fmt::format("a frame {}", why)); };
    const auto fields = JsonFields::parse(text_of(message.data));
    if (!fields)
        return std::unexpected(fields.error());
    if (message.stamp.log_time_ns > static_cast<std::uint64_t>(Duration::max().count()))
        return refused("with a time beyond the year 2262");
    Captured out{.at = Time{Duration{static_cast<std::int64_t>(message.stamp.log_time_ns)}}};
    if (const auto* bus = message.channel->find("bus"))
        out.bus = *bus;
    if (const auto* family = message.channel->find("family"))
        out.family = *family;
    if (const auto* direction = fields->text("direction"))
        out.direction = *direction == "request" ? Direction::request : Direction::reply;
    if (const auto* verdict = fields->text("verdict"); verdict != nullptr && *verdict != "sent" && *verdict != "taken")
        out.discarded = *verdict;
    if (const auto* discarded = fields->text("discarded"))
        out.discarded = *discarded;
    const auto* text = fields->text("bytes");
    auto bytes = text == nullptr || text->empty() ? std::expected<std::vector<std::uint8_t>, Error>{} : from_hex(*text);
    if (!bytes)
        return refused("whose bytes are no hex");
    const auto can_id = fields->number("can_id");
    if (!can_id) {
        out.bytes = *std::move(bytes);
        return out;
    }
    constexpr double highest_id = 0x1FFF'FFFF;
    constexpr std::size_t most_data = 8;
    if (!(*can_id >= 0 && *can_id <= highest_id) || bytes->size() > most_data)
        return refused("that cannot be on CAN");
    const auto* kind = fields->text("kind");
    out.kind = kind == nullptr         ? Captured::Kind::can
               : *kind == "can_remote" ? Captured::Kind::can_remote
                                       : Captured::Kind::can_error;
    out.extended = fields->flag("extended").value_or(false);
    out.frame.can_id = static_cast<std::uint32_t>(*can_id);
    out.frame.size = static_cast<std::uint8_t>(bytes->size());
    std::ranges::copy(*bytes, out.frame.data.begin());
    if (out.kind == Captured::Kind::can_remote)
        out.frame.size = static_cast<std::uint8_t>(std::clamp(fields->number("size").value_or(0), 0.0, 8.0));
    return out;
}

} // namespace sinew::record
