#pragma once
#include "apps/cli/verb.hpp"
#include "sinew/family/families.hpp"
#include "sinew/wire/values.hpp"

#include <memory>

/// A device as the command sees it: what it is, where it is, and how its numbers are read.
namespace sinew::cli {

/// What is known of a device. Without a `spec` (no model given or found) its messages go by the manual's line, and the
/// scales that depend on the model stay raw.
struct Device {
    std::string name; ///< the joint, or "sam 3"
    std::string link; ///< of its bus
    const Family* family = nullptr;
    int id = -1;
    std::optional<DeviceSpec> spec;
    const config::Joint* joint = nullptr;          ///< nullptr: named by link, family and id
    const wire::Profile* asked_line = nullptr;     ///< of a device without a spec
    std::shared_ptr<const config::RobotFile> file; ///< that `joint` points into

    const wire::Profile& line() const { return spec ? line_of(*spec) : *asked_line; }
    wire::Options options() const { return spec ? options_of(*spec) : line().options; }
    std::span<const wire::Override> overrides() const
    {
        return spec ? overrides_of(*spec) : std::span<const wire::Override>{};
    }
    Duration response_time() const { return spec ? response_time_of(*spec) : family->response_time.typical; }
    std::string_view model() const { return spec ? model_of(*spec) : std::string_view{}; }
    wire::Reading reading(const wire::MessageInfo& message, const wire::Field& field) const
    {
        return wire::reading(message, field, line().overrides, overrides());
    }
    bool answers(const wire::MessageInfo& message) const;
};

/// What went wrong with a device, in the words of whoever named it: a joint by its name and not by its id, and silence
/// of a recording as that.
Error about(const Device& device, Error error);

/// The end of a sentence that says that there is no such name: the nearest of those there are, else all.
std::string suggestion(std::string_view name, std::span<const std::string_view> names);
/// Names with a suggestion, for errors.
std::expected<const Family*, Error> family_named(std::string_view name);
std::expected<const wire::Profile*, Error> profile_named(const Family& family, std::string_view name);
/// `unknown_name` with the nearest, `not_in_profile` for a message of another line of the family.
std::expected<const wire::MessageInfo*, Error> message_named(const Family& family, const wire::Profile& line,
                                                             std::string_view name);

/// A device by words, without a link. An id outside the family's range is `bad_id`.
std::expected<Device, Error> device_of(const Words& words, std::string_view link);

/// The bytes of a request from values by name, with everything a bus needs to carry it out.
std::expected<wire::Request, Error> request(const Device& device, const wire::MessageInfo& message,
                                            const wire::Values& values);

/// What a reply says. A reply that breaks its row is `bad_reply`, whatever the reason.
std::expected<wire::Values, Error> reply_values(const wire::Request& asked, const wire::Frame& reply);

// The options that name a device, for the rows of the verbs.
inline constexpr Option robot_option{"--robot", "FILE",
                                     "the robot file that has the joint, or a recording of it (or SINEW_ROBOT)"};
inline constexpr Option link_option{"--link", "BUS=LINK", "another link for a bus of the robot file", true};
inline constexpr Option sim_option{"--sim", "", "simulate the robot file in this command; no device is touched"};
inline constexpr Option family_option{"--family", "F", "sam, nuri or rmd"};
inline constexpr Option id_option{"--id", "N", "the id of the device"};
inline constexpr Option model_option{"--model", "M", "its model; a SAM is asked for it where it is not given"};
inline constexpr Option profile_option{"--profile", "P", "its firmware line; the manual's where it is not given"};
inline constexpr Option json_option{"--json", "", "print JSON"};
inline constexpr Option yes_option{"--yes", "", "do not ask"};
inline constexpr Argument target_argument{"TARGET", "a joint of a robot file, or a link with --family and --id"};

std::vector<Option> with_device_options(std::vector<Option> before);

} // namespace sinew::cli
