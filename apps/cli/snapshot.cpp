#include "apps/cli/confirm.hpp"
#include "apps/cli/device_settings.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/link/adapter.hpp"

#include <algorithm>
#include <deque>
#include <fmt/format.h>
#include <sys/utsname.h>

namespace sinew::cli {
namespace {

constexpr std::size_t most_frames = 400;

struct Frame {
    TimePoint at{};
    wire::Direction direction{};
    std::vector<std::uint8_t> bytes;
    std::uint32_t can_id = 0;
    bus::Verdict verdict{};
};

/// What passed last on one bus.
using Frames = std::deque<Frame>;

void keep(Frames& frames, const bus::Tapped& seen)
{
    frames.push_back({seen.at, seen.direction, {seen.bytes.begin(), seen.bytes.end()}, seen.can_id, seen.verdict});
    if (frames.size() > most_frames)
        frames.pop_front();
}

Json error_json(const Error& error)
{
    return Json::object({{"code", to_word(error.code)}, {"sentence", to_sentence(error)}});
}

Json settings_json(const config::DeviceEntry& entry)
{
    Json out = Json::object();
    for (const auto* group : {&entry.settings, &entry.calibration})
        for (const auto& setting : *group) {
            Json values = Json::object();
            for (const auto& value : setting.values)
                if (const auto* raw = std::get_if<std::int64_t>(&value.value))
                    values.set(value.key, *raw);
            out.set(setting.name, std::move(values));
        }
    return out;
}

struct Described {
    Json says;
    bool is_read = false;
};

/// One device, as far as it answers: what is wrong with it is what the snapshot is for.
Described describe(Session& session, const Device& device)
{
    Json out = Json::object({{"name", device.name},
                             {"family", device.family->name},
                             {"id", device.id},
                             {"link", device.link},
                             {"flash_writes", flash_writes(device)}});
    auto driven = drive(session, device);
    if (!driven) {
        out.set("error", error_json(driven.error()));
        return {std::move(out)};
    }
    out.set("model", driven->device.model());
    out.set("profile", driven->device.line().name);
    const auto read = read_state(*driven, actuator::Depth::full);
    if (!read)
        out.set("state", Json::object({{"error", error_json(read.error())}}));
    else
        out.set("state", state_json(*driven, {}));
    const auto entry = read_entry(*driven->bus, driven->device);
    out.set("settings", entry ? settings_json(*entry) : Json::object({{"error", error_json(entry.error())}}));
    return {std::move(out), read.has_value()};
}

std::optional<link::Adapter> adapter_of(const std::string& link)
{
    const auto uri = link::parse_uri(link);
    if (!uri || (uri->scheme != "serial" && uri->scheme != "rs485" && uri->scheme != "slcan"))
        return std::nullopt;
    return link::look_at_adapter(uri->target);
}

Json adapter_json(const std::string& link, bool with_private)
{
    const auto found = adapter_of(link);
    if (!found)
        return {};
    const auto& adapter = *found;
    Json out = Json::object({{"driver", adapter.driver}, {"is_there", adapter.is_there}});
    if (adapter.latency_timer_ms)
        out.set("latency_timer_ms", *adapter.latency_timer_ms);
    if (with_private) {
        out.set("by_id", adapter.by_id);
        out.set("serial_number", adapter.serial_number);
    }
    return out;
}

Json bus_json(const bus::Bus& bus, const Frames& frames, TimePoint begin, bool with_private)
{
    const auto& seen = bus.conversation().counters();
    Json last = Json::array();
    for (const auto& frame : frames) {
        Json one = Json::object({{"time_s", seconds(frame.at - begin)},
                                 {"direction", frame.direction == wire::Direction::request ? "sent" : "received"},
                                 {"verdict", to_word(frame.verdict)},
                                 {"bytes", to_hex(frame.bytes)}});
        if (frame.can_id != 0)
            one.set("can_id", frame.can_id);
        last.add(std::move(one));
    }
    return Json::object({{"link", bus.name()},
                         {"bit_rate", bus.link_state().bit_rate},
                         {"adapter", adapter_json(bus.name(), with_private)},
                         {"requests", static_cast<std::int64_t>(seen.requests)},
                         {"timeouts", static_cast<std::int64_t>(seen.timeouts)},
                         {"late", static_cast<std::int64_t>(seen.late)},
                         {"strays", static_cast<std::int64_t>(seen.strays)},
                         {"bad_checksums", static_cast<std::int64_t>(seen.bad_checksums)},
                         {"last_frames", std::move(last)}});
}

/// A link that is not there is what many a report is about.
Json missing_json(const std::string& link, const Error& error, bool with_private)
{
    return Json::object({{"link", link}, {"error", error_json(error)}, {"adapter", adapter_json(link, with_private)}});
}

/// Of the first frame that is known.
TimePoint beginning(const std::map<bus::Bus*, Frames>& frames)
{
    TimePoint begin = TimePoint::max();
    for (const auto& [bus, seen] : frames)
        if (!seen.empty())
            begin = std::min(begin, seen.front().at);
    return begin;
}

Json host_json()
{
    utsname name{};
    ::uname(&name);
    return Json::object({{"system", name.sysname}, {"release", name.release}, {"machine", name.machine}});
}

std::string what_is_private(const Words& words, const std::string& path)
{
    std::string out = fmt::format("{} will have the versions of sinew and of the system, the links, the settings and "
                                  "states of the devices, and the last frames.",
                                  path);
    if (!words.has("--no-private"))
        out += " Private in it may be: the whole robot file with its names and comments, and the serial numbers of "
               "adapters (--no-private leaves these out); names of files and hosts in the links stay";
    return out;
}

/// What is in it that its sender may want to look at first.
Json private_json(const std::vector<Device>& devices, bool has_robot_file, bool with_private)
{
    Json out = Json::array();
    if (has_robot_file)
        out.add("robot_file");
    const auto names_itself = [](const Device& device) {
        const auto adapter = adapter_of(device.link);
        return adapter && !(adapter->serial_number.empty() && adapter->by_id.empty());
    };
    if (with_private && std::ranges::any_of(devices, names_itself))
        out.add("serial_numbers");
    out.add("links");
    return out;
}

Outcome run(const Words& words)
{
    const auto path = words.text("--output");
    if (!path)
        return fail(Errc::bad_argument, "--output FILE is missing: where the snapshot goes, such as --output bug.json");
    auto devices = targets(words);
    if (!devices)
        return std::unexpected(devices.error());
    const auto yes = confirm(words, what_is_private(words, *path));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    auto file = NewFile::make(*path);
    if (!file)
        return std::unexpected(file.error());
    const bool with_private = !words.has("--no-private");

    std::map<bus::Bus*, Frames> frames; // outlives the buses that show theirs to it
    Session session;
    std::map<std::string, Error> missing;
    Json all = Json::array(), unread = Json::array();
    for (const auto& device : *devices) {
        progress(fmt::format("Reading {}", device.name));
        if (const auto bus = session.bus_of(device); !bus)
            missing.emplace(device.link, bus.error());
        else if (!frames.contains(*bus))
            (*bus)->set_tap([&into = frames[*bus]](const bus::Tapped& seen) { keep(into, seen); });
        auto described = describe(session, device);
        all.add(std::move(described.says));
        if (!described.is_read)
            unread.add(device.name);
    }
    end_progress();
    Json buses = Json::array();
    for (const auto& [bus, seen] : frames)
        buses.add(bus_json(*bus, seen, beginning(frames), with_private));
    for (const auto& [link, error] : missing)
        buses.add(missing_json(link, error, with_private));
    Json out = Json::object({{"snapshot", 1}, {"sinew", SINEW_VERSION}, {"host", host_json()}});
    const auto& robot = devices->front().file;
    if (robot && with_private)
        out.set("robot_file", robot_text_at(robot->path).value_or(""));
    out.set("buses", std::move(buses));
    out.set("devices", std::move(all));
    if (auto written = file->write(out.pretty() + "\n"); !written)
        return std::unexpected(written.error());
    if (auto kept = file->keep(); !kept)
        return std::unexpected(kept.error());
    if (words.json())
        print(Json::object({{"file", *path},
                            {"private", private_json(*devices, robot && with_private, with_private)},
                            {"buses", static_cast<std::int64_t>(frames.size() + missing.size())},
                            {"devices", static_cast<std::int64_t>(devices->size())},
                            {"unread", std::move(unread)}}));
    fmt::print(stderr, "{} is written; read it before you send it to anybody.\n", *path);
    return exit_done;
}

} // namespace

Verb snapshot_verb()
{
    return {
        .name = "snapshot",
        .says = "Write one file that says all about a robot, for a report of what is wrong.",
        .arguments = {{"TARGET", "a joint, or a link with --family and --id; without it all joints of --robot", false}},
        .options =
            with_device_options({{"--output", "FILE", "the file, as JSON"},
                                 {"--no-private", "", "without the robot file and the serial numbers of adapters"},
                                 yes_option,
                                 {"--json", "", "print what was written, and what is private in it"}}),
        .examples = {{"sinew snapshot --robot arm.toml --output bug.json", "says what is private in it, and asks"},
                     {"sinew snapshot elbow --robot arm.toml --sim --output bug.json --yes", "one joint, simulated"}},
        .run = run,
        .more = "It only reads. A device that does not answer, or a link that is not there, is in the file with what "
                "went wrong; the exit code is 0 "
                "once the file is written."};
}

} // namespace sinew::cli
