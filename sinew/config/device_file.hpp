#pragma once
#include "sinew/config/robot_file.hpp"

/// What is known of devices, as a file: their settings, or how often their flash was written.
///
///     version = 1
///     [device.elbow]
///     family = "sam"
///     id = 3
///     [device.elbow.settings]
///     pd-gain = { p_gain = 30, d_gain = 20 }
///     [device.elbow.calibration]
///     encoder-offset = { encoder_offset = 100 }
///
/// The file knows no family: which settings there are is in the room of the families.
namespace sinew::config {

/// The values of one setting.
struct DeviceSetting {
    std::string name;
    Mark at;
    std::vector<Setting> values;
    std::string says{}; ///< a comment behind it; not read
};

struct DeviceEntry {
    std::string name;
    Mark at;
    std::vector<Setting> facts; ///< the keys that are no tables
    std::vector<DeviceSetting> settings;
    std::vector<DeviceSetting> calibration;

    /// The text or the number of a fact; nothing where it is not there or of another kind.
    std::optional<std::string> text(std::string_view key) const;
    std::optional<std::int64_t> whole(std::string_view key) const;
};

struct DeviceFile {
    std::string path; ///< as given, for messages
    std::vector<DeviceEntry> devices;

    const DeviceEntry* find(std::string_view name) const; ///< nullptr: none
};

/// `bad_file` with "FILE:LINE:COLUMN: what is wrong and what would be right".
std::expected<DeviceFile, Error> parse_device_file(std::string_view text, std::string path);

std::expected<DeviceFile, Error> read_device_file(const std::filesystem::path& path);

/// The file as text, entries in their order. Names and keys must be such as a file may have.
std::string to_toml(const DeviceFile& file);

/// A text with the marks that TOML wants around it.
std::string toml_text(std::string_view text);

/// A `bad_file` error at a place of this file.
std::unexpected<Error> fail_at(const DeviceFile& file, Mark at, std::string what);

} // namespace sinew::config
