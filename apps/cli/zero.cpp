#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/presence.hpp"
#include "sinew/base/units.hpp"
#include "sinew/family/settings.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

struct Act {
    const ZeroInfo* zero = nullptr;
    wire::Request request;
};

std::expected<Act, Error> act_from(const Words& words, const Device& device)
{
    const bool stored = words.has("--store");
    const auto& line = device.line();
    const auto* zero = zero_of(*device.family, line, stored);
    if (zero == nullptr)
        return fail(Errc::unsupported,
                    fmt::format("{} has no message that makes the present position its {}zero on the firmware line {}; "
                                "--in-file prints what the robot file can say instead",
                                device.family->name, stored ? "stored " : "", line.name));
    if (words.has("--undo") && zero->undo < 0)
        return fail(Errc::unsupported,
                    fmt::format("{} cannot take a zero back; give it another one", device.family->name));
    std::vector<std::string> fields;
    if (!zero->field.empty())
        fields.push_back(fmt::format("{}={}", zero->field, words.has("--undo") ? zero->undo : zero->raw));
    const auto& message = *line.find(zero->message);
    const auto values = values_from(device, message, fields);
    if (!values)
        return std::unexpected(values.error());
    auto asked = request(device, message, *values);
    if (!asked)
        return std::unexpected(asked.error());
    return Act{zero, *asked};
}

/// What the robot file would say so that the joint stands at zero now.
Outcome print_for_file(const Words& words, Device device)
{
    Session session;
    auto driven = drive(session, std::move(device));
    if (!driven)
        return std::unexpected(driven.error());
    if (auto read = read_state(*driven, actuator::Depth::motion); !read)
        return std::unexpected(read.error());
    const double zero_rad = driven->state.position_rad.value_or(0.0);
    if (words.json())
        print(Json::object({{"device", driven->device.name}, {"zero_rad", zero_rad}}));
    else
        fmt::print("[joint.{}]\nzero_deg = {:.3f}\n", driven->device.joint != nullptr ? driven->device.name : "NAME",
                   units::deg(zero_rad));
    return exit_done;
}

std::expected<double, Error> actuator_position(Driven& driven)
{
    if (auto read = read_state(driven, actuator::Depth::motion); !read)
        return std::unexpected(read.error());
    return driven.state.position_rad.value_or(0.0);
}

Outcome carry_out_act(const Words& words, Device device, const Act& act)
{
    Session session;
    auto driven = drive(session, std::move(device));
    if (!driven)
        return std::unexpected(driven.error());
    const auto before = actuator_position(*driven);
    if (!before)
        return std::unexpected(before.error());
    if (const auto sent = ask_counted(*driven->bus, driven->device, act.request); !sent)
        return std::unexpected(sent.error());
    constexpr Duration settle = std::chrono::milliseconds(50); // Nuri does not answer: it may take a moment
    wait_until(session, session.clock().now() + settle);
    const auto after = actuator_position(*driven);
    if (!after)
        return std::unexpected(after.error());
    const auto& name = driven->device.name;
    if (words.json())
        print(Json::object({{"device", name},
                            {"message", act.request.message->name()},
                            {"before_rad", *before},
                            {"after_rad", *after}}));
    else
        fmt::print("{}  {:.2f} deg before, {:.2f} deg now\n", name, units::deg(*before), units::deg(*after));
    fmt::print(stderr, "Of this zero: {}.\n", act.zero->says);
    if (const auto* joint = driven->device.joint; joint != nullptr && joint->zero_rad != 0.0)
        fmt::print(stderr, "{} says zero_deg = {:g} for {}, counted from the zero of the device.\n",
                   driven->device.file->path, units::deg(joint->zero_rad), name);
    const bool stored = act.request.message->info.access == wire::Access::flash;
    const double fine = std::max(units::rad(1.5), 2.0 * driven->driver->capabilities().position_step_rad);
    if (!stored && !words.has("--undo") && std::abs(*after) > fine)
        return fail(Errc::unsupported,
                    fmt::format("{} was told that it stands at zero and says {:.2f} deg", name, units::deg(*after)));
    return exit_done;
}

Outcome run(const Words& words)
{
    if (words.has("--in-file") && (words.has("--store") || words.has("--undo")))
        return fail(Errc::bad_argument, "--in-file changes nothing in the device; give it without --store and --undo");
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (words.has("--in-file"))
        return print_for_file(words, std::move(*device));
    const auto act = act_from(words, *device);
    if (!act)
        return std::unexpected(act.error());
    if (words.has("--dry-run")) {
        show_unsent(words, *device, {&act->request, 1});
        return exit_done;
    }
    const bool stores = act->request.message->info.access == wire::Access::flash;
    const auto yes = confirm(words, fmt::format("{} will take its present position for zero{}, and may move",
                                                device->name, stores ? ", which writes its flash" : ""));
    if (!yes)
        return std::unexpected(yes.error());
    return *yes ? carry_out_act(words, std::move(*device), *act) : Outcome(exit_refused);
}

} // namespace

Verb zero_verb()
{
    return {.name = "zero",
            .says = "Make the present position of a device its zero.",
            .arguments = {target_argument},
            .options = with_device_options(
                {{"--in-file", "", "print the line for the robot file instead; the device keeps its zero"},
                 {"--store", "", "in flash; RMD only, and it counts after the next power-on"},
                 {"--undo", "", "take it back; SAM only"},
                 dry_run_option,
                 yes_option,
                 json_option}),
            .examples = {{"sinew zero waist_yaw --robot arm.toml", "asks first"},
                         {"sinew zero left_knee --robot arm.toml --sim --yes", "a simulated one"},
                         {"sinew zero elbow --robot arm.toml --in-file", "for the robot file"}},
            .run = run,
            .acts = true,
            .more = "A device that holds a target may turn when its zero changes: release it first (sinew stop)."};
}

} // namespace sinew::cli
