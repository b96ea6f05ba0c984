// What TARGET and the options name: the half of session.hpp that opens nothing.
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/session.hpp"
#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr std::string_view how_to_name_a_device =
    "name a joint with --robot FILE, or a link with --family and --id, such as serial:/dev/ttyUSB0?baud=1500000 "
    "--family sam --id 1";

/// What says who a device on a link is.
constexpr const char* device_words[] = {"--family", "--id", "--model", "--profile"};

std::expected<std::shared_ptr<const config::RobotFile>, Error> read_robot(const std::string& path)
{
    auto file = robot_file_at(path);
    if (!file)
        return std::unexpected(file.error());
    return std::make_shared<const config::RobotFile>(std::move(*file));
}

std::expected<void, Error> check_source(const Words& words)
{
    if (words.has("--sim") && words.has("--link"))
        return fail(Errc::bad_argument,
                    "--sim takes every bus from the simulator, and --link from elsewhere; give one");
    return {};
}

std::expected<std::string, Error> link_of(const std::map<std::string, std::string>& given, const Device& device)
{
    const auto& file = *device.file;
    const auto& bus = *file.find_bus(device.joint->bus.value);
    const auto named = given.find(bus.name);
    const std::string link = named != given.end() ? named->second : bus.link ? bus.link->value : std::string{};
    if (link.empty())
        return fail(
            Errc::bad_argument,
            fmt::format("bus {} of {} has no link: give it with --link {}=LINK, as `sinew sim {}` prints it, or "
                        "write link = \"...\" into the file",
                        bus.name, file.path, bus.name, file.path));
    const auto rate = bus.bit_rate ? static_cast<std::uint32_t>(bus.bit_rate->value) : 0;
    return with_bit_rate(link, *device.family, rate);
}

std::expected<void, Error> check_live(const Words& words, const Device& device)
{
    return words.act ? check_live(device) : std::expected<void, Error>{};
}

std::expected<std::vector<Device>, Error> joints_of(const Words& words, const std::string& path,
                                                    std::optional<std::string_view> only)
{
    auto all = devices_in(path);
    if (!all)
        return all;
    std::vector<std::string_view> names;
    for (const auto& device : *all)
        names.push_back(device.joint->name);
    if (only && std::ranges::find(names, *only) == names.end())
        return fail(Errc::unknown_name, fmt::format("{} has no joint '{}'{}", path, *only, suggestion(*only, names)));
    if (only)
        std::erase_if(*all, [&](const Device& device) { return device.joint->name != *only; });
    if (auto given = give_links(words, *all); !given)
        return std::unexpected(given.error());
    for (const auto& device : *all)
        if (auto live = check_live(words, device); !live)
            return std::unexpected(live.error());
    return all;
}

} // namespace

std::expected<void, Error> check_live(const Device& device)
{
    if (!record::is_replay(device.link))
        return {};
    return fail(Errc::bad_argument,
                fmt::format("{} is a recording: what it has can be read, and not moved, stopped or set; name the robot "
                            "file or the link of the device itself",
                            link::parse_uri(device.link)->target));
}

std::optional<std::string> robot_path(const Words& words)
{
    if (const auto given = words.text("--robot"))
        return given;
    const char* environment = std::getenv("SINEW_ROBOT");
    return environment != nullptr && *environment != '\0' ? std::optional<std::string>(environment) : std::nullopt;
}

std::expected<std::vector<Device>, Error> devices_in(const std::string& path)
{
    const auto file = read_robot(path);
    if (!file)
        return std::unexpected(file.error());
    auto robot = resolve(**file);
    if (!robot)
        return std::unexpected(robot.error());
    std::vector<Device> out;
    for (auto& joint : robot->joints)
        out.push_back({.name = joint.joint->name,
                       .link = joint.bus->link ? joint.bus->link->value : std::string{},
                       .family = joint.family,
                       .id = sinew::id_of(joint.device),
                       .spec = std::move(joint.device),
                       .joint = joint.joint,
                       .file = *file});
    return out;
}

std::expected<void, Error> give_links(const Words& words, std::vector<Device>& devices)
{
    if (auto fine = check_source(words); !fine)
        return fine;
    for (auto& device : devices) {
        if (words.has("--sim")) {
            if (is_recording(device.file->path))
                return fail(Errc::bad_argument,
                            fmt::format("--sim needs a robot file, and {} is a recording", device.file->path));
            device.link = fmt::format("sim:{}#{}", device.file->path, device.joint->bus.value);
            continue;
        }
        const auto given = given_links(words, *device.file);
        if (!given)
            return std::unexpected(given.error());
        auto link = link_of(*given, device);
        if (!link)
            return std::unexpected(link.error());
        device.link = std::move(*link);
    }
    return {};
}

std::expected<void, Error> no_sim_for(const Words& words, std::string_view link)
{
    if (words.has("--sim"))
        return fail(Errc::bad_argument,
                    fmt::format("--sim simulates a robot file, not the link {}; name a joint with --robot FILE", link));
    return {};
}

bool is_link(std::string_view word)
{
    return word.find(':') != std::string_view::npos || word.find('/') != std::string_view::npos;
}

bool is_robot_file(std::string_view word)
{
    return word.ends_with(".toml") && word.find(':') == std::string_view::npos;
}

std::expected<void, Error> no_family_for(const Words& words)
{
    if (words.has("--family"))
        return fail(Errc::bad_argument, "--family goes with a link; the robot file says it for its buses");
    return {};
}

std::string with_bit_rate(const std::string& link, const Family& family, std::uint32_t bit_rate)
{
    return link::with_bit_rate(link, bit_rate != 0 ? bit_rate : family.default_bit_rate);
}

std::expected<std::map<std::string, std::string>, Error> given_links(const Words& words, const config::RobotFile& file)
{
    if (auto fine = check_source(words); !fine)
        return std::unexpected(fine.error());
    std::vector<std::string_view> names;
    for (const auto& bus : file.buses)
        names.push_back(bus.name);
    std::map<std::string, std::string> out;
    for (const std::string_view word : words.all("--link")) {
        const auto equals = std::min(word.find('='), word.size());
        const auto bus = word.substr(0, equals);
        if (equals == word.size() || !is_link(word.substr(equals + 1)))
            return fail(
                Errc::bad_argument,
                fmt::format("--link takes BUS=LINK, such as left=serial:/dev/ttyUSB0?baud=1500000, not '{}'", word));
        if (std::ranges::find(names, bus) == names.end())
            return fail(Errc::unknown_name,
                        fmt::format("{} has no bus '{}'{}", file.path, bus, suggestion(bus, names)));
        out.insert_or_assign(std::string(bus), std::string(word.substr(equals + 1)));
    }
    return out;
}

bool has_robot(const Words& words)
{
    return robot_path(words).has_value();
}

std::expected<Device, Error> target(const Words& words)
{
    const std::string word = words.text("TARGET").value_or("");
    if (is_link(word)) {
        if (auto fine = no_sim_for(words, word); !fine)
            return std::unexpected(fine.error());
        auto device = device_of(words, word);
        if (!device)
            return device;
        device->link = with_bit_rate(device->link, *device->family);
        if (auto live = check_live(words, *device); !live)
            return std::unexpected(live.error());
        return device;
    }
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument,
                    fmt::format("'{}' is no link, and there is no robot file that could have such a "
                                "joint: {}",
                                word, how_to_name_a_device));
    for (const auto* option : device_words)
        if (words.has(option))
            return fail(Errc::bad_argument,
                        fmt::format("{} goes with a link; for the joint {} the robot file says it", option, word));
    auto joints = joints_of(words, *path, word);
    if (!joints)
        return std::unexpected(joints.error());
    return std::move(joints->front());
}

std::expected<std::vector<Device>, Error> targets(const Words& words)
{
    if (!words.has("TARGET"))
        return whole_robot(words);
    auto one = target(words);
    if (!one)
        return std::unexpected(one.error());
    std::vector<Device> out;
    out.push_back(std::move(*one));
    return out;
}

std::expected<std::vector<Device>, Error> whole_robot(const Words& words)
{
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, fmt::format("which device? Please {}", how_to_name_a_device));
    // Who names a device must not have the whole robot moved instead.
    for (const auto* option : device_words)
        if (words.has(option))
            return fail(Errc::bad_argument, fmt::format("{} goes with a link, and without TARGET all joints of {} are "
                                                        "meant; name a joint, or leave {} out",
                                                        option, *path, option));
    return robot_at(words, *path);
}

std::expected<std::vector<Device>, Error> robot_at(const Words& words, const std::string& path)
{
    auto joints = joints_of(words, path, std::nullopt);
    return joints && joints->empty() ? no_joints(path) : std::move(joints);
}

std::unexpected<Error> no_joints(const std::string& path)
{
    return fail(Errc::bad_file, fmt::format("{} has no joints; write [joint.NAME] into it", path));
}

} // namespace sinew::cli
