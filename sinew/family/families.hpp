#pragma once
#include "sinew/base/error.hpp"
#include "sinew/base/time.hpp"
#include "sinew/config/robot_file.hpp"
#include "sinew/family/nuri/models.hpp"
#include "sinew/family/rmd/models.hpp"
#include "sinew/family/sam/models.hpp"
#include "sinew/wire/profile.hpp"
#include "sinew/wire/protocol.hpp"

#include <cstdint>
#include <expected>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// The one list of families, and what a robot file means: the same for the robot and for the simulator.
namespace sinew {

/// A product of a family by name.
struct ModelInfo {
    std::string_view name;
    std::string_view says;
};

struct BitRate {
    int code = 0; ///< in the set-baud-rate messages
    std::uint32_t bps = 0;
};

/// How long a device may take between the end of a request and the start of its answer.
struct ResponseTime {
    Duration typical{};
    Duration most{}; ///< with every setting that a device may have
};

/// A key of `profile_options` or `sim`.
struct OptionInfo {
    std::string_view key;
    std::string_view says; ///< what may be written
};

/// A vendor protocol. Lives as long as the program.
struct Family {
    std::string_view name;
    std::string_view title;
    bool can = false;
    const wire::Protocol* protocol = nullptr;
    std::span<const wire::Profile* const> profiles; ///< the first is the manual's, and the default
    std::span<const ModelInfo> models;
    wire::Range ids;                    ///< of single devices
    int default_id = 0;                 ///< as delivered
    int broadcast_id = -1;              ///< addresses all devices in the messages that allow it; -1: none
    std::span<const BitRate> bit_rates; ///< what a device can be set to
    std::uint32_t default_bit_rate = 0; ///< as delivered
    ResponseTime response_time;
    std::span<const OptionInfo> profile_options;
    std::span<const OptionInfo> sim_options;

    const wire::Profile* find_profile(std::string_view profile) const; ///< nullptr: none
};

std::span<const Family* const> families();
const Family* find_family(std::string_view name); ///< nullptr: none

// ---- one device ----

/// Model, firmware line, id and options of one device, checked and worked out.
using DeviceSpec = std::variant<sam::Spec, nuri::Spec, rmd::Spec>;

/// A device by words, for whoever has no robot file. An empty profile is the default of the model. An empty model is
/// "RSA" or "RMD"; SAM has none, because every scale depends on it. `unknown_name` suggests the nearest.
std::expected<DeviceSpec, Error> make_spec(const Family& family, std::string_view model, std::string_view profile,
                                           int id);

const Family& family_of(const DeviceSpec& device);
int id_of(const DeviceSpec& device);
std::string_view model_of(const DeviceSpec& device);
/// The messages that this device has. The views below live as long as `device` stays where it is.
const wire::Profile& line_of(const DeviceSpec& device);
wire::Options options_of(const DeviceSpec& device);
/// What model and options change in the reading of rows; for `wire::reading` after those of the line.
std::span<const wire::Override> overrides_of(const DeviceSpec& device);
Duration response_time_of(const DeviceSpec& device);
/// Whether the product has this message at all: some of SAM's belong to the encoder models.
bool offers(const DeviceSpec& device, const wire::MessageInfo& message);
/// Whether the device answers this message when it alone is asked: SAM by response level, Nuri feedback requests only,
/// RMD always.
bool answers(const DeviceSpec& device, const wire::MessageInfo& message);

// ---- a robot file ----

/// A joint with its bus and device. The pointers go into the `RobotFile` it was made from, which must stay.
struct ResolvedJoint {
    const config::Joint* joint = nullptr;
    const config::Bus* bus = nullptr;
    const Family* family = nullptr;
    DeviceSpec device;
};

struct ResolvedRobot {
    std::vector<ResolvedJoint> joints; ///< in the order of the file
};

/// Checks families, models, profiles, ids and options. `bad_file` with place and suggestion; nothing is half done.
std::expected<ResolvedRobot, Error> resolve(const config::RobotFile& file);

} // namespace sinew
