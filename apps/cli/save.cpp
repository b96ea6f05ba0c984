#include "apps/cli/device_settings.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/terminal.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr std::string_view head =
    "# Settings of devices. `sinew diff` compares them with what is there, `sinew restore` "
    "writes them.\n";

Json to_json(const std::vector<config::DeviceSetting>& settings)
{
    Json out = Json::object();
    for (const auto& setting : settings) {
        Json values = Json::object();
        for (const auto& value : setting.values)
            if (const auto* raw = std::get_if<std::int64_t>(&value.value))
                values.set(value.key, *raw);
        out.set(setting.name, std::move(values));
    }
    return out;
}

Json to_json(const config::DeviceEntry& entry)
{
    Json out = Json::object({{"name", entry.name}});
    for (const auto& fact : entry.facts)
        if (const auto* text = std::get_if<std::string>(&fact.value))
            out.set(fact.key, *text);
        else if (const auto* whole = std::get_if<std::int64_t>(&fact.value))
            out.set(fact.key, *whole);
    out.set("settings", to_json(entry.settings));
    out.set("calibration", to_json(entry.calibration));
    return out;
}

Outcome write(const Words& words, const config::DeviceFile& file)
{
    if (words.json()) {
        Json out = Json::array();
        for (const auto& device : file.devices)
            out.add(to_json(device));
        print(out);
        return exit_done;
    }
    const auto text = std::string(head) + config::to_toml(file);
    const auto path = words.text("--output");
    if (!path) {
        fmt::print("{}", text);
        return exit_done;
    }
    auto out = NewFile::make(*path);
    if (!out)
        return std::unexpected(out.error());
    if (auto written = out->write(text); !written)
        return std::unexpected(written.error());
    if (auto kept = out->keep(); !kept)
        return std::unexpected(kept.error());
    fmt::print(stderr, "{} has the settings of {} {}.\n", *path, file.devices.size(),
               file.devices.size() == 1 ? "device" : "devices");
    return exit_done;
}

Outcome run(const Words& words)
{
    if (words.json() && words.has("--output"))
        return fail(Errc::bad_argument, "--json goes to stdout, and the file is TOML; give --json or --output");
    auto devices = targets(words);
    if (!devices)
        return std::unexpected(devices.error());
    Session session;
    config::DeviceFile file;
    for (auto& device : *devices) {
        progress(fmt::format("Reading {}", device.name));
        const auto bus = session.bus_of(device);
        if (!bus)
            return std::unexpected(bus.error());
        if (auto found = find_model(device, **bus); !found)
            return std::unexpected(found.error());
        auto entry = read_entry(**bus, device);
        if (!entry)
            return std::unexpected(entry.error());
        file.devices.push_back(std::move(*entry));
    }
    end_progress();
    return write(words, file);
}

} // namespace

Verb save_verb()
{
    return {
        .name = "save",
        .says = "Read all settings of a device or of a whole robot, and print them as TOML.",
        .arguments = {{"TARGET", "a joint, or a link with --family and --id; without it all joints of --robot", false}},
        .options = with_device_options({{"--output", "FILE", "into this file, whole or not at all"}, json_option}),
        .examples = {{"sinew save --robot arm.toml --output kept.toml", "all joints"},
                     {"sinew save serial:/dev/ttyUSB0 --family sam --id 1", "one device, on the screen"},
                     {"sinew save left_knee --robot arm.toml --sim --json", "for a program"}},
        .run = run,
        .more = "A setting is what a device can be told and asked for. Gains are those in use, which may have been "
                "set until power-off. Ids, bit rates and motion programs are not among them. What belongs to one "
                "device alone, such as the offset of its encoder, stands under calibration. The numbers are those of "
                "the wire; what they mean stands behind them."};
}

} // namespace sinew::cli
