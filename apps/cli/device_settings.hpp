#pragma once
#include "apps/cli/session.hpp"
#include "sinew/config/device_file.hpp"
#include "sinew/family/settings.hpp"

/// The settings of a device as values that can be kept, compared and written back: for `save`, `diff` and `restore`.
namespace sinew::cli {

struct KnownSetting {
    LineSetting setting;
    wire::Values values; ///< what the message that writes it needs, as the device has it
};

/// The settings that this very device has: of its line, its model and its id.
std::vector<LineSetting> settings_of(const Device& device);

/// Reads one.
std::expected<wire::Values, Error> read_setting(bus::Bus& bus, const Device& device, const LineSetting& setting);
/// Reads all of them. The first failure ends it.
std::expected<std::vector<KnownSetting>, Error> read_settings(bus::Bus& bus, const Device& device);

/// As it stands in a file: who the device is, and its settings with what they mean as comments. Asks the device for its
/// firmware version.
std::expected<config::DeviceEntry, Error> read_entry(bus::Bus& bus, const Device& device);

/// "sam-3" for "sam 3": names in files have no blanks.
std::string file_name_of(const Device& device);

/// The entry for a device: that of `name` where it is given, else that of the device's own name or, in a file of one
/// device, that one.
std::expected<const config::DeviceEntry*, Error> entry_for(const config::DeviceFile& file, const Device& device,
                                                           const std::optional<std::string>& name = {});

/// TARGET or, without it, the joints of the robot file that the file of settings has. `unknown_name` for a device of
/// the file that the robot does not have.
std::expected<std::vector<Device>, Error> targets_of(const Words& words, const config::DeviceFile& file);

/// `unsupported` with a sentence where the entry is of another kind of device: family, model and firmware line must be
/// the same, and what the device itself says of its model counts as well.
std::expected<void, Error> check_same_kind(const config::DeviceFile& file, const config::DeviceEntry& entry,
                                           const Device& device, bus::Bus* bus);

/// A setting of a file, checked against the rows.
struct WantedSetting {
    LineSetting setting;
    wire::Values values;
    wire::Request write;
    bool calibration = false;
};

/// In the order in which they are to be written. `bad_file` with the place of what is unknown, missing or out of range.
std::expected<std::vector<WantedSetting>, Error> wanted_settings(const config::DeviceFile& file,
                                                                 const config::DeviceEntry& entry,
                                                                 const Device& device);

bool same(const wire::Values& a, const wire::Values& b);

/// One field that is not the same.
struct Difference {
    std::string device;
    std::string setting;
    std::string field;
    std::optional<std::int64_t> a, b; ///< nothing: not there
};

/// Of two entries, field by field, calibration too.
std::vector<Difference> differences(const config::DeviceEntry& a, const config::DeviceEntry& b);

} // namespace sinew::cli
