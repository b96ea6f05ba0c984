#include "sinew/config/device_file.hpp"

#include "sinew/config/reader.hpp"

namespace sinew::config {
namespace {

constexpr std::string_view owner = "a file of devices";
constexpr std::string_view file_keys[] = {"version", "device"};

std::vector<DeviceSetting> read_settings(Reader& reader, const toml::table& device, std::string_view group)
{
    return read_named<DeviceSetting>(reader, device, group,
                                     [](Reader& from, const toml::table& table, std::string name, Mark at) {
                                         return DeviceSetting{std::move(name), at, from.settings(&table)};
                                     });
}

DeviceEntry read_device(Reader& reader, const toml::table& table, std::string name, Mark at)
{
    DeviceEntry device{.name = std::move(name), .at = at};
    toml::table facts = table;
    facts.erase("settings");
    facts.erase("calibration");
    device.facts = reader.settings(&facts);
    device.settings = read_settings(reader, table, "settings");
    device.calibration = read_settings(reader, table, "calibration");
    return device;
}

const Setting* find(const std::vector<Setting>& all, std::string_view key)
{
    const auto found = std::ranges::find(all, key, &Setting::key);
    return found == all.end() ? nullptr : &*found;
}

std::string value_text(const Setting& setting)
{
    struct Writer {
        std::string operator()(std::int64_t value) const { return fmt::format("{}", value); }
        std::string operator()(double value) const
        {
            auto text = fmt::format("{}", value);
            return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
        }
        std::string operator()(const std::string& value) const { return toml_text(value); }
        std::string operator()(bool value) const { return value ? "true" : "false"; }
    };
    return std::visit(Writer{}, setting.value);
}

void add_group(std::string& out, std::string_view device, std::string_view group,
               const std::vector<DeviceSetting>& settings)
{
    if (settings.empty())
        return;
    out += fmt::format("[device.{}.{}]\n", device, group);
    for (const auto& setting : settings) {
        out += fmt::format("{} = {{", setting.name);
        for (std::size_t i = 0; i < setting.values.size(); ++i)
            out += fmt::format("{} {} = {}", i == 0 ? "" : ",", setting.values[i].key, value_text(setting.values[i]));
        out += setting.says.empty() ? " }\n" : fmt::format(" }} # {}\n", setting.says);
    }
}

} // namespace

std::string toml_text(std::string_view text)
{
    std::string out = "\"";
    for (const char c : text)
        if (c == '"' || c == '\\')
            out += fmt::format("\\{}", c);
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
            out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
        else
            out += c;
    return out + '"';
}

std::optional<std::string> DeviceEntry::text(std::string_view key) const
{
    const auto* setting = find(facts, key);
    const auto* value = setting != nullptr ? std::get_if<std::string>(&setting->value) : nullptr;
    return value != nullptr ? std::optional(*value) : std::nullopt;
}

std::optional<std::int64_t> DeviceEntry::whole(std::string_view key) const
{
    const auto* setting = find(facts, key);
    const auto* value = setting != nullptr ? std::get_if<std::int64_t>(&setting->value) : nullptr;
    return value != nullptr ? std::optional(*value) : std::nullopt;
}

const DeviceEntry* DeviceFile::find(std::string_view name) const
{
    const auto found = std::ranges::find(devices, name, &DeviceEntry::name);
    return found == devices.end() ? nullptr : &*found;
}

std::unexpected<Error> fail_at(const DeviceFile& file, Mark at, std::string what)
{
    return fail_at(std::string_view(file.path), at, std::move(what));
}

std::expected<DeviceFile, Error> parse_device_file(std::string_view text, std::string path)
{
    return parse_file<DeviceFile>(text, std::move(path), owner, file_keys,
                                  [](Reader& reader, const toml::table& document, DeviceFile& file) {
                                      file.devices = read_named<DeviceEntry>(reader, document, "device", read_device);
                                  });
}

std::expected<DeviceFile, Error> read_device_file(const std::filesystem::path& path)
{
    return read_file<DeviceFile>(path, owner, parse_device_file);
}

std::string to_toml(const DeviceFile& file)
{
    std::string out = "version = 1\n";
    for (const auto& device : file.devices) {
        out += fmt::format("\n[device.{}]\n", device.name);
        for (const auto& fact : device.facts)
            out += fmt::format("{} = {}\n", fact.key, value_text(fact));
        add_group(out, device.name, "settings", device.settings);
        add_group(out, device.name, "calibration", device.calibration);
    }
    return out;
}

} // namespace sinew::config
