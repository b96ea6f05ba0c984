#include "apps/cli/device_settings.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/terminal.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::string number(const std::optional<std::int64_t>& value)
{
    return value ? std::to_string(*value) : "-";
}

Outcome show(const Words& words, const std::vector<Difference>& all, std::string_view a, std::string_view b)
{
    if (words.json()) {
        Json out = Json::array();
        for (const auto& one : all)
            out.add(Json::object(
                {{"device", one.device}, {"setting", one.setting}, {"field", one.field}, {"a", one.a}, {"b", one.b}}));
        print(Json::object({{"a", a}, {"b", b}, {"differences", std::move(out)}}));
    } else if (!all.empty()) {
        Table table({"DEVICE", "SETTING", "FIELD", std::string(a), std::string(b)});
        for (const auto& one : all)
            table.add({one.device, one.setting, one.field, number(one.a), number(one.b)});
        const auto text = table.text();
        if (text.substr(0, text.find('\n')).contains("SETTING")) {
            fmt::print("{}", text);
            return exit_differs;
        }
        Table named({"", "", "", "", ""}); // rows that are stacked have no head
        for (const auto& one : all)
            named.add({one.device, one.setting, one.field, fmt::format("{} {}", a, number(one.a)),
                       fmt::format("{} {}", b, number(one.b))});
        fmt::print("{}", named.text());
    } else {
        fmt::print("no difference\n");
    }
    return all.empty() ? exit_done : exit_differs;
}

Outcome with_file(const Words& words, const config::DeviceFile& file, const std::string& other_path)
{
    const auto other = config::read_device_file(other_path);
    if (!other)
        return std::unexpected(other.error());
    std::vector<Difference> all;
    for (const auto& entry : file.devices) {
        const auto* beside = other->find(entry.name);
        const auto found = differences(entry, beside != nullptr ? *beside : config::DeviceEntry{.name = entry.name});
        all.insert(all.end(), found.begin(), found.end());
    }
    for (const auto& entry : other->devices)
        if (file.find(entry.name) == nullptr) {
            const auto found = differences({.name = entry.name}, entry);
            all.insert(all.end(), found.begin(), found.end());
        }
    return show(words, all, file.path, other_path);
}

Outcome with_devices(const Words& words, const config::DeviceFile& file)
{
    auto devices = targets_of(words, file);
    if (!devices)
        return std::unexpected(devices.error());
    Session session;
    std::vector<Difference> all;
    for (auto& device : *devices) {
        progress(fmt::format("Reading {}", device.name));
        const auto entry = entry_for(file, device);
        if (!entry)
            return std::unexpected(entry.error());
        const auto bus = session.bus_of(device);
        if (!bus)
            return std::unexpected(bus.error());
        if (auto found = find_model(device, **bus); !found)
            return std::unexpected(found.error());
        if (auto fine = check_same_kind(file, **entry, device, *bus); !fine)
            return std::unexpected(fine.error());
        auto is = read_entry(**bus, device);
        if (!is)
            return std::unexpected(is.error());
        const auto found = differences(**entry, *is);
        all.insert(all.end(), found.begin(), found.end());
    }
    end_progress();
    return show(words, all, "FILE", "DEVICE");
}

Outcome run(const Words& words)
{
    const auto file = config::read_device_file(*words.text("FILE"));
    if (!file)
        return std::unexpected(file.error());
    const auto other = words.text("TARGET");
    return other && other->ends_with(".toml") && other->find(':') == std::string::npos ? with_file(words, *file, *other)
                                                                                       : with_devices(words, *file);
}

} // namespace

Verb diff_verb()
{
    return {.name = "diff",
            .says = "Compare saved settings with those of the devices, or with another file.",
            .arguments = {{"FILE", "what `sinew save` wrote"},
                          {"TARGET", "a joint, a link with --family and --id, or a second file; without it all of FILE",
                           false}},
            .options = with_device_options({json_option}),
            .examples = {{"sinew diff kept.toml --robot arm.toml", "everything that was kept"},
                         {"sinew diff kept.toml elbow --robot arm.toml --sim", "one joint, simulated"},
                         {"sinew diff kept.toml then.toml", "two files"}},
            .run = run,
            .more = "The exit code is 0 where nothing differs and 13 where something does. Nothing is written.",
            .ends = {exit_differs}};
}

} // namespace sinew::cli
