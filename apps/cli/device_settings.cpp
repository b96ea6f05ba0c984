#include "apps/cli/device_settings.hpp"

#include "apps/cli/present.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/family/sam/messages.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

/// What `write` needs but the selector, which the name of the setting says.
bool is_kept(const LineSetting& setting, const wire::Field& field)
{
    return setting.info->selected < 0 || field.name != setting.write->request.selector;
}

/// What the raw numbers mean, where they mean more than themselves.
std::string meaning(const Device& device, const KnownSetting& known)
{
    std::vector<std::string> parts;
    for (const auto& shown : show(device, *known.setting.write, known.values))
        if (!shown.label.empty() || shown.value)
            parts.push_back(fmt::format("{} {}", shown.name, text(shown)));
    return fmt::format("{}", fmt::join(parts, ", "));
}

config::DeviceSetting to_file(const Device& device, const KnownSetting& known)
{
    config::DeviceSetting out{.name = std::string(known.setting.info->name)};
    for (const auto& value : known.values)
        if (is_kept(known.setting, *value.field))
            out.values.push_back({std::string(value.field->name), value.raw, {}});
    out.says = meaning(device, known);
    return out;
}

/// The firmware version, of families that tell one.
std::expected<std::optional<std::int64_t>, Error> firmware(bus::Bus& bus, const Device& device)
{
    for (const auto& [name, field] :
         {std::pair{"read-firmware-version", "fw_version"}, std::pair{"request-firmware-version-feedback", "version"}})
        if (const auto* message = device.line().find(name)) {
            const auto asked = request(device, *message, {});
            if (!asked)
                return std::unexpected(asked.error());
            const auto said = ask(bus, *asked);
            if (!said)
                return std::unexpected(about(device, said.error()));
            return said->find(field);
        }
    return std::nullopt;
}

std::expected<WantedSetting, Error> wanted(const config::DeviceFile& file, const config::DeviceSetting& kept,
                                           const Device& device, const LineSetting& setting)
{
    wire::Values said;
    const auto fields =
        wire::value_fields(setting.write->request, device.options(),
                           setting.info->selected < 0 ? std::nullopt : std::optional(setting.info->selected));
    std::vector<std::string_view> names;
    for (const auto& value : fields)
        if (is_kept(setting, *value.field))
            names.push_back(value.field->name);
    for (const auto& value : kept.values) {
        const auto field = std::ranges::find(fields, value.key, [](const auto& one) { return one.field->name; });
        const auto* raw = std::get_if<std::int64_t>(&value.value);
        if (field == fields.end() || !is_kept(setting, *field->field))
            return fail_at(
                file, value.at,
                fmt::format("{} has no field '{}'; it has {}.", kept.name, value.key, fmt::join(names, ", ")));
        if (raw == nullptr)
            return fail_at(file, value.at, fmt::format("{} must be a whole number.", value.key));
        said.add(*field->field, *raw);
    }
    const auto values = written_values(setting, *setting.write, said, device.options());
    if (!values)
        return fail_at(file, kept.at, fmt::format("{} needs {}.", kept.name, fmt::join(names, " and ")));
    auto asked = request(device, *setting.write, *values);
    if (!asked)
        return fail_at(file, kept.at, fmt::format("{} cannot be: {}.", kept.name, to_sentence(asked.error())));
    return WantedSetting{.setting = setting, .values = *values, .write = *asked};
}

std::map<std::string, std::int64_t> fields_of(const config::DeviceEntry& entry)
{
    std::map<std::string, std::int64_t> out;
    for (const auto* group : {&entry.settings, &entry.calibration})
        for (const auto& setting : *group)
            for (const auto& value : setting.values)
                if (const auto* raw = std::get_if<std::int64_t>(&value.value))
                    out.emplace(setting.name + '\n' + value.key, *raw);
    return out;
}

} // namespace

std::vector<LineSetting> settings_of(const Device& device)
{
    auto all = sinew::settings_of(*device.family, device.line());
    std::erase_if(all, [&](const LineSetting& one) {
        return (device.spec && (!offers(*device.spec, *one.read) || !offers(*device.spec, *one.write))) ||
               !wire::request_ids(*one.read).contains(device.id);
    });
    return all;
}

std::expected<wire::Values, Error> read_setting(bus::Bus& bus, const Device& device, const LineSetting& setting)
{
    const auto asked = request(device, *setting.read, read_values(setting, device.options()));
    if (!asked)
        return std::unexpected(asked.error());
    const auto said = ask(bus, *asked);
    if (!said)
        return std::unexpected(about(device, said.error()));
    return written_values(setting, *setting.write, *said, device.options());
}

std::expected<std::vector<KnownSetting>, Error> read_settings(bus::Bus& bus, const Device& device)
{
    std::vector<KnownSetting> out;
    for (const auto& setting : settings_of(device)) {
        const auto values = read_setting(bus, device, setting);
        if (!values)
            return std::unexpected(values.error());
        out.push_back({setting, *values});
    }
    return out;
}

std::string file_name_of(const Device& device)
{
    std::string out = device.name;
    std::ranges::replace(out, ' ', '-');
    return out;
}

std::expected<config::DeviceEntry, Error> read_entry(bus::Bus& bus, const Device& device)
{
    const auto all = read_settings(bus, device);
    if (!all)
        return std::unexpected(all.error());
    const auto version = firmware(bus, device);
    if (!version)
        return std::unexpected(version.error());
    config::DeviceEntry out{.name = file_name_of(device)};
    const auto fact = [&](const char* key, auto value) { out.facts.push_back({key, value, {}}); };
    fact("family", std::string(device.family->name));
    if (!device.model().empty())
        fact("model", std::string(device.model()));
    fact("profile", std::string(device.line().name));
    fact("id", static_cast<std::int64_t>(device.id));
    if (*version)
        fact("firmware", **version);
    for (const auto& known : *all)
        (known.setting.info->calibration ? out.calibration : out.settings).push_back(to_file(device, known));
    return out;
}

std::expected<const config::DeviceEntry*, Error> entry_for(const config::DeviceFile& file, const Device& device,
                                                           const std::optional<std::string>& name)
{
    if (const auto* entry = file.find(name.value_or(file_name_of(device))))
        return entry;
    if (file.devices.size() == 1 && !name)
        return &file.devices.front();
    std::vector<std::string_view> names;
    for (const auto& one : file.devices)
        names.push_back(one.name);
    return fail(Errc::unknown_name,
                fmt::format("{} has nothing of {}; it has {}", file.path, name.value_or(device.name),
                            names.empty() ? "no device" : fmt::format("{}", fmt::join(names, ", "))));
}

std::expected<std::vector<Device>, Error> targets_of(const Words& words, const config::DeviceFile& file)
{
    auto devices = targets(words);
    if (!devices || words.has("TARGET"))
        return devices;
    for (const auto& entry : file.devices)
        if (std::ranges::find(*devices, entry.name, &Device::name) == devices->end())
            return fail(Errc::unknown_name, fmt::format("{} has settings of {}, and {} has no such joint; name the one "
                                                        "that is meant",
                                                        file.path, entry.name, devices->front().file->path));
    std::erase_if(*devices, [&](const Device& one) { return file.find(one.name) == nullptr; });
    return devices;
}

std::expected<void, Error> check_same_kind(const config::DeviceFile& file, const config::DeviceEntry& entry,
                                           const Device& device, bus::Bus* bus)
{
    const auto differ = [&](std::string_view what, std::string_view kept, std::string_view is) {
        return fail(Errc::unsupported,
                    fmt::format("{} of {} is of the {} {}, and {} is of the {} {}: settings of one mean "
                                "something else in the other; nothing was written",
                                entry.name, file.path, what, kept, device.name, what, is));
    };
    const auto kept = [&](const char* key) { return entry.text(key).value_or(std::string{}); };
    if (kept("family") != device.family->name)
        return differ("family", kept("family"), device.family->name);
    if (!kept("model").empty() && !device.model().empty() && kept("model") != device.model())
        return differ("model", kept("model"), device.model());
    if (kept("profile") != device.line().name)
        return differ("firmware line", kept("profile"), device.line().name);
    // A robot file may be wrong about what is really there.
    if (bus == nullptr || device.family->name != "sam")
        return {};
    const auto said = bus->call(device.id, sam::ReadFirmwareVersion{});
    if (!said)
        return std::unexpected(about(device, said.error()));
    const auto* model = sam::find_model(said->model_number);
    if (model != nullptr && !kept("model").empty() && model->name != kept("model"))
        return differ("model", kept("model"), model->name);
    return {};
}

std::expected<std::vector<WantedSetting>, Error> wanted_settings(const config::DeviceFile& file,
                                                                 const config::DeviceEntry& entry, const Device& device)
{
    const auto known = settings_of(device);
    std::vector<std::string_view> names;
    for (const auto& one : known)
        names.push_back(one.info->name);
    std::vector<WantedSetting> out;
    for (const auto* group : {&entry.settings, &entry.calibration})
        for (const auto& kept : *group) {
            const auto setting =
                std::ranges::find(known, kept.name, [](const LineSetting& one) { return one.info->name; });
            if (setting == known.end()) {
                const auto near = did_you_mean(kept.name, names);
                return fail_at(
                    file, kept.at,
                    fmt::format("{} has no setting '{}'{}", device.name, kept.name, near.empty() ? "." : near));
            }
            auto one = wanted(file, kept, device, *setting);
            if (!one)
                return std::unexpected(one.error());
            one->calibration = setting->info->calibration;
            out.push_back(*one);
        }
    std::ranges::sort(out, {}, [&](const WantedSetting& one) {
        return std::ranges::find(names, one.setting.info->name) - names.begin();
    });
    return out;
}

bool same(const wire::Values& a, const wire::Values& b)
{
    return std::ranges::all_of(a, [&](const auto& one) { return b.find(one.field->name) == one.raw; });
}

std::vector<Difference> differences(const config::DeviceEntry& a, const config::DeviceEntry& b)
{
    const auto in_a = fields_of(a);
    const auto in_b = fields_of(b);
    std::vector<Difference> out;
    const auto add = [&](const std::string& key, std::optional<std::int64_t> of_a, std::optional<std::int64_t> of_b) {
        const auto end = key.find('\n');
        if (of_a != of_b)
            out.push_back({a.name, key.substr(0, end), key.substr(end + 1), of_a, of_b});
    };
    for (const auto& [key, value] : in_a)
        add(key, value, in_b.contains(key) ? std::optional(in_b.at(key)) : std::nullopt);
    for (const auto& [key, value] : in_b)
        if (!in_a.contains(key))
            add(key, std::nullopt, value);
    return out;
}

} // namespace sinew::cli
