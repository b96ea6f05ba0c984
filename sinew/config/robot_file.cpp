#include "sinew/config/robot_file.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/config/motion_reader.hpp"
#include "sinew/config/reader.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <span>

namespace sinew::config {
namespace {

constexpr std::string_view file_keys[] = {"version", "name", "bus", "joint", "pose", "sequence", "safety", "sim"};
constexpr std::string_view bus_keys[] = {"family", "link", "bit_rate", "rate_hz", "realtime", "sim"};
constexpr std::string_view realtime_keys[] = {"lock_memory", "priority", "processor"};
constexpr std::string_view safety_keys[] = {"policy",        "on_fault",     "command_timeout_s", "temperature_max_c",
                                            "current_max_a", "step_max_rad", "step_max_deg",      "silence_max_s",
                                            "stop_time_s"};
constexpr std::string_view home_keys[] = {"routine",        "direction",      "position_rad",   "position_deg",
                                          "velocity_rad_s", "velocity_deg_s", "travel_max_rad", "travel_max_deg"};
constexpr std::string_view joint_keys[] = {"bus",
                                           "id",
                                           "model",
                                           "profile",
                                           "direction",
                                           "zero_rad",
                                           "zero_deg",
                                           "ratio",
                                           "position_min_rad",
                                           "position_min_deg",
                                           "position_max_rad",
                                           "position_max_deg",
                                           "velocity_max_rad_s",
                                           "velocity_max_deg_s",
                                           "current_max_a",
                                           "torque_max_nm",
                                           "step_max_rad",
                                           "step_max_deg",
                                           "temperature_max_c",
                                           "stop_time_s",
                                           "home",
                                           "acceleration_max_rad_s2",
                                           "acceleration_max_deg_s2",
                                           "jerk_max_rad_s3",
                                           "jerk_max_deg_s3",
                                           "profile_options",
                                           "runtime",
                                           "sim",
                                           "plant"};

/// One of a few words; the first where none is given. How many it is.
std::size_t read_word(Reader& reader, const toml::table& table, std::string_view key,
                      std::span<const std::string_view> words)
{
    const auto word = reader.text(table, key);
    if (!word)
        return 0;
    const auto at = std::ranges::find(words, word->value);
    if (at == words.end())
        reader.fail(word->at, fmt::format("{} must be one of {}.", key, fmt::join(words, ", ")));
    return at == words.end() ? 0 : static_cast<std::size_t>(at - words.begin());
}

std::optional<double> positive_angle(Reader& reader, const toml::table& table, std::string_view radians,
                                     std::string_view degrees)
{
    const auto value = reader.angle(table, radians, degrees);
    if (value && value->value <= 0.0)
        reader.fail(value->at, fmt::format("{} must be above 0.", degrees));
    return value ? std::optional(value->value) : std::nullopt;
}

RealTime read_realtime(Reader& reader, const toml::table* table, std::string_view owner)
{
    RealTime out;
    if (table == nullptr)
        return out;
    reader.only(*table, owner, realtime_keys);
    if (const auto lock = reader.flag(*table, "lock_memory"))
        out.lock_memory = lock->value;
    out.priority = reader.whole(*table, "priority");
    if (out.priority && (out.priority->value < 1 || out.priority->value > 99))
        reader.fail(out.priority->at, "priority must be from 1 to 99.");
    out.processor = reader.whole(*table, "processor");
    if (out.processor && out.processor->value < 0)
        reader.fail(out.processor->at, "processor must not be below 0.");
    return out;
}

Safety read_safety(Reader& reader, const toml::table* table)
{
    Safety safety;
    if (table == nullptr)
        return safety;
    constexpr std::string_view policies[] = {"hold", "release", "brake"};
    constexpr std::string_view reach[] = {"all", "joint"};
    reader.only(*table, "safety", safety_keys);
    safety.policy = static_cast<Policy>(read_word(reader, *table, "policy", policies));
    safety.whole_robot = read_word(reader, *table, "on_fault", reach) == 0;
    safety.command_timeout_s = reader.positive(*table, "command_timeout_s");
    safety.temperature_max_c = reader.positive(*table, "temperature_max_c");
    safety.current_max_a = reader.positive(*table, "current_max_a");
    safety.step_max_rad = positive_angle(reader, *table, "step_max_rad", "step_max_deg");
    safety.silence_max_s = reader.positive(*table, "silence_max_s").value_or(safety.silence_max_s);
    safety.stop_time_s = reader.positive(*table, "stop_time_s").value_or(safety.stop_time_s);
    return safety;
}

Home read_home(Reader& reader, const toml::table* table, std::string_view owner)
{
    Home home;
    if (table == nullptr)
        return home;
    constexpr std::string_view routines[] = {"position", "stop"};
    reader.only(*table, owner, home_keys);
    home.to_stop = read_word(reader, *table, "routine", routines) == 1;
    if (const auto direction = reader.whole(*table, "direction")) {
        if (direction->value != 1 && direction->value != -1)
            reader.fail(direction->at, "direction must be 1 or -1.");
        home.direction = static_cast<int>(direction->value);
    }
    if (const auto position = reader.angle(*table, "position_rad", "position_deg"))
        home.position_rad = position->value;
    home.velocity_rad_s =
        positive_angle(reader, *table, "velocity_rad_s", "velocity_deg_s").value_or(home.velocity_rad_s);
    home.travel_max_rad = positive_angle(reader, *table, "travel_max_rad", "travel_max_deg");
    return home;
}

Bus read_bus(Reader& reader, const toml::table& table, std::string name, Mark at)
{
    const std::string owner = "bus " + name;
    reader.only(table, owner, bus_keys);
    Bus bus{.name = std::move(name), .at = at};
    bus.family = needed(reader, reader.text(table, "family"), at, owner, "family");
    bus.link = reader.text(table, "link");
    bus.bit_rate = reader.whole(table, "bit_rate");
    if (bus.bit_rate && bus.bit_rate->value <= 0)
        reader.fail(bus.bit_rate->at, "bit_rate must be above 0.");
    bus.rate_hz = reader.positive(table, "rate_hz");
    bus.realtime = read_realtime(reader, reader.section(table, "realtime"), owner + ": realtime");
    bus.sim = reader.settings(reader.section(table, "sim"));
    return bus;
}

void read_mounting(Reader& reader, const toml::table& table, Joint& joint)
{
    if (const auto direction = reader.whole(table, "direction")) {
        if (direction->value != 1 && direction->value != -1)
            reader.fail(direction->at, "direction must be 1 or -1.");
        joint.direction = static_cast<int>(direction->value);
    }
    if (const auto zero = reader.angle(table, "zero_rad", "zero_deg"))
        joint.zero_rad = zero->value;
    if (const auto ratio = reader.real(table, "ratio")) {
        if (ratio->value <= 0.0)
            reader.fail(ratio->at, "ratio must be above 0; use direction = -1 to turn the joint round.");
        joint.ratio = ratio->value;
    }
}

void read_limits(Reader& reader, const toml::table& table, Joint& joint)
{
    const auto low = reader.angle(table, "position_min_rad", "position_min_deg");
    const auto high = reader.angle(table, "position_max_rad", "position_max_deg");
    const auto speed = reader.angle(table, "velocity_max_rad_s", "velocity_max_deg_s");
    if (low && high && low->value >= high->value)
        reader.fail(low->at, "the lowest position must be below the highest.");
    if (speed && speed->value <= 0.0)
        reader.fail(speed->at, "the greatest velocity must be above 0.");
    if (low)
        joint.position_min_rad = low->value;
    if (high)
        joint.position_max_rad = high->value;
    if (speed)
        joint.velocity_max_rad_s = speed->value;
    joint.current_max_a = reader.positive(table, "current_max_a");
    joint.torque_max_nm = reader.positive(table, "torque_max_nm");
    joint.step_max_rad = positive_angle(reader, table, "step_max_rad", "step_max_deg");
    joint.temperature_max_c = reader.positive(table, "temperature_max_c");
    joint.stop_time_s = reader.positive(table, "stop_time_s");
    joint.acceleration_max_rad_s2 = positive_angle(reader, table, "acceleration_max_rad_s2", "acceleration_max_deg_s2");
    joint.jerk_max_rad_s3 = positive_angle(reader, table, "jerk_max_rad_s3", "jerk_max_deg_s3");
}

Joint read_joint(Reader& reader, const toml::table& table, std::string name, Mark at)
{
    const std::string owner = "joint " + name;
    reader.only(table, owner, joint_keys);
    Joint joint{.name = std::move(name), .at = at};
    joint.bus = needed(reader, reader.text(table, "bus"), at, owner, "bus");
    joint.id = needed(reader, reader.whole(table, "id"), at, owner, "id");
    joint.model = reader.text(table, "model");
    joint.profile = reader.text(table, "profile");
    read_mounting(reader, table, joint);
    read_limits(reader, table, joint);
    joint.home = read_home(reader, reader.section(table, "home"), owner + ": home");
    joint.options = reader.settings(reader.section(table, "profile_options"));
    joint.runtime = reader.settings(reader.section(table, "runtime"));
    joint.sim = reader.settings(reader.section(table, "sim"));
    joint.plant = reader.settings(reader.section(table, "plant"));
    return joint;
}

/// A link without its options, which say how it is opened and not where it leads.
std::string place_of(std::string_view link)
{
    const auto options = std::min(link.find('?'), link.size());
    const auto fragment = std::min(link.find('#'), link.size());
    return std::string(link.substr(0, std::min(options, fragment))) + std::string(link.substr(fragment));
}

const Bus* bus_on(std::span<const Bus> buses, std::string_view link)
{
    const auto at = std::ranges::find_if(
        buses, [&](const Bus& bus) { return bus.link && place_of(bus.link->value) == place_of(link); });
    return at == buses.end() ? nullptr : &*at;
}

void check_links(Reader& reader, const RobotFile& file)
{
    for (std::size_t i = 0; i < file.buses.size(); ++i)
        if (const auto& link = file.buses[i].link)
            if (const Bus* other = bus_on(std::span(file.buses).first(i), link->value))
                reader.fail(link->at, fmt::format("buses {} and {} have the same link; a link carries one bus.",
                                                  other->name, file.buses[i].name));
}

void check_buses(Reader& reader, const RobotFile& file)
{
    std::vector<std::string_view> names;
    for (const Bus& bus : file.buses)
        names.push_back(bus.name);
    for (const Joint& joint : file.joints)
        if (!file.find_bus(joint.bus.value)) {
            const std::string near = did_you_mean(joint.bus.value, names);
            reader.fail(joint.bus.at,
                        fmt::format("there is no bus '{}'{}", joint.bus.value, near.empty() ? "." : near));
        }
}

} // namespace

std::string_view to_word(Policy policy)
{
    switch (policy) {
    case Policy::hold:
        return "hold";
    case Policy::release:
        return "release";
    case Policy::brake:
        return "brake";
    }
    return "?";
}

const Bus* RobotFile::find_bus(std::string_view bus) const
{
    const auto at = std::ranges::find(buses, bus, &Bus::name);
    return at == buses.end() ? nullptr : &*at;
}

const Joint* RobotFile::find_joint(std::string_view joint) const
{
    const auto at = std::ranges::find(joints, joint, &Joint::name);
    return at == joints.end() ? nullptr : &*at;
}

const Pose* RobotFile::find_pose(std::string_view pose) const
{
    const auto at = std::ranges::find(poses, pose, &Pose::name);
    return at == poses.end() ? nullptr : &*at;
}

const Sequence* RobotFile::find_sequence(std::string_view sequence) const
{
    const auto at = std::ranges::find(sequences, sequence, &Sequence::name);
    return at == sequences.end() ? nullptr : &*at;
}

std::unexpected<Error> fail_at(const RobotFile& file, Mark at, std::string what)
{
    return fail_at(std::string_view(file.path), at, std::move(what));
}

std::expected<RobotFile, Error> parse_robot_file(std::string_view text, std::string path)
{
    RobotFile file{.path = std::move(path)};
    auto parsed = parse_document(text, file.path);
    if (!parsed)
        return std::unexpected(std::move(parsed.error()));
    const toml::table& document = *parsed;
    Reader reader{file.path};
    // The version comes first: another one may have other keys.
    check_version(reader, document, "a robot file");
    reader.only(document, "a robot file", file_keys);
    if (auto name = reader.text(document, "name"))
        file.name = std::move(name->value);
    file.buses = read_named<Bus>(reader, document, "bus", read_bus);
    file.joints = read_named<Joint>(reader, document, "joint", read_joint);
    file.safety = read_safety(reader, reader.section(document, "safety"));
    read_motion(reader, document, file);
    if (const toml::table* sim = reader.section(document, "sim")) {
        file.sim = reader.settings(sim, "fault");
        file.faults = reader.sections(*sim, "fault");
    }
    check_buses(reader, file);
    check_links(reader, file);
    if (reader.failed())
        return std::unexpected(reader.take_error());
    return file;
}

std::expected<RobotFile, Error> read_robot_file(const std::filesystem::path& path)
{
    const auto text = read_text(path, "a robot file");
    if (!text)
        return std::unexpected(text.error());
    return parse_robot_file(*text, path.string());
}

} // namespace sinew::config
