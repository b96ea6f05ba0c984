#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/motion_file.hpp"
#include "apps/cli/presence.hpp"
#include "sinew/family/sam/messages.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::expected<std::vector<wire::Pair>, Error> program_from(const Words& words)
{
    const auto path = words.text("FILE");
    if (path.has_value() == words.has("--none"))
        return fail(Errc::bad_argument, "name the file of the program, or say --none to switch the stored one off");
    return path ? read_motion(*path) : std::vector<wire::Pair>{};
}

/// The device tells how many instructions it has, and nothing else of its program.
Outcome verify(const Words& words, bus::Bus& bus, const Device& device, std::span<const wire::Pair> program)
{
    const auto said = bus.call(device.id, sam::ReadMotionData{});
    if (!said)
        return std::unexpected(said.error());
    if (said->motion_count != program.size())
        return fail(Errc::bad_reply, fmt::format("{} says that it has {} instructions and was given {}", device.name,
                                                 said->motion_count, program.size()));
    if (words.json())
        print(Json::object({{"device", device.name},
                            {"instructions", static_cast<std::int64_t>(program.size())},
                            {"bytes", motion_bytes(program)}}));
    else
        fmt::print("{}  {}\n", device.name,
                   program.empty() ? std::string("no program") : fmt::format("{} instructions", program.size()));
    return exit_done;
}

Outcome run(const Words& words)
{
    const auto program = program_from(words);
    if (!program)
        return std::unexpected(program.error());
    const auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const auto asked = motion_request(*device, *program);
    if (!asked)
        return std::unexpected(asked.error());
    if (words.has("--dry-run")) {
        show_unsent(words, *device, {&*asked, 1});
        return exit_done;
    }
    const auto yes = confirm(
        words, fmt::format("{} will {}, which writes its flash", device->name,
                           program->empty() ? "get no program" : "run this program, now and whenever it has power"));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    Session session;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    if (const auto sent = ask_counted(**bus, *device, *asked); !sent)
        return std::unexpected(sent.error());
    return verify(words, **bus, *device, *program);
}

} // namespace

Verb motion_upload_verb()
{
    return {.name = "motion upload",
            .says = "Store a self-running program in a SAM.",
            .arguments = {target_argument,
                          {"FILE", "the text of the program, as for sinew motion assemble; - is stdin", false}},
            .options = with_device_options(
                {{"--none", "", "switch the stored program off instead"}, dry_run_option, yes_option, json_option}),
            .examples = {{"sinew motion upload elbow wave.motion --robot arm.toml --dry-run", "the bytes"},
                         {"sinew motion upload elbow wave.motion --robot arm.toml --sim --yes", "a simulated one"},
                         {"sinew motion upload elbow --none --robot arm.toml", "asks first"}},
            .run = run,
            .more =
                "The servo runs it at once and whenever it has power, with nobody at its bus; a motion command stops "
                "it until then. Try it first: sinew motion simulate."};
}

} // namespace sinew::cli
