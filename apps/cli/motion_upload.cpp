#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/motion_file.hpp"
#include "apps/cli/presence.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/family/sam/messages.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::expected<sam::Program, Error> program_from(const Words& words)
{
    const auto path = words.text("FILE");
    if (path.has_value() == words.has("--none"))
        return fail(Errc::bad_argument, "name the file of the program, or say --none to switch the stored one off");
    return path ? read_motion(*path) : sam::Program{};
}

void show_as_program(const Words& words, const Device& device, const wire::Request& asked,
                     std::span<const wire::Pair> program)
{
    if (words.json())
        return show_unsent(words, device, {&asked, 1});
    fmt::print("{}  {}  {}\n{}", bold("would send"), to_text(asked.frame, false), asked.message->name(),
               sam::disassemble(program));
}

/// A device tells how many instructions it has, and nothing else of its program.
std::expected<std::size_t, Error> stored(bus::Bus& bus, const Device& device)
{
    const auto said = bus.call(device.id, sam::ReadMotionData{});
    if (!said)
        return std::unexpected(about(device, said.error()));
    return said->motion_count;
}

void tell(const Words& words, const Device& device, std::span<const wire::Pair> program, bool written)
{
    if (words.json())
        print(Json::object({{"device", device.name},
                            {"instructions", static_cast<std::int64_t>(program.size())},
                            {"bytes", motion_bytes(program)},
                            {"written", written}}));
    else
        fmt::print("{}  {}\n", device.name, program.empty() ? std::string("no program") : instructions(program.size()));
    if (!written)
        fmt::print(stderr, "It has none already; the flash was not written.\n");
}

Outcome upload(const Words& words, bus::Bus& bus, const Device& device, const wire::Request& asked,
               std::span<const wire::Pair> program)
{
    if (const auto sent = ask_counted(bus, device, asked); !sent)
        return std::unexpected(sent.error());
    const auto kept = stored(bus, device);
    if (!kept)
        return std::unexpected(kept.error());
    if (*kept != program.size())
        return fail(Errc::bad_reply, fmt::format("{} says that it has {} and was given {}", device.name,
                                                 instructions(*kept), program.size()));
    tell(words, device, program, true);
    return exit_done;
}

std::string question(const Device& device, std::span<const wire::Pair> program)
{
    if (program.empty())
        return fmt::format("{} will get no program, which writes its flash", device.name);
    return fmt::format("{} will run this program, now and whenever it has power, which writes its flash even where it "
                       "has this one already, for a program cannot be read back",
                       device.name);
}

Outcome run(const Words& words)
{
    const auto text = program_from(words);
    if (!text)
        return std::unexpected(text.error());
    const auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const std::span<const wire::Pair> program = text->instructions;
    const auto asked = motion_request(*device, program);
    if (!asked)
        return std::unexpected(asked.error());
    if (const auto within = check_motion(*device, *text); !within)
        return std::unexpected(within.error());
    if (words.has("--dry-run")) {
        show_as_program(words, *device, *asked, program);
        return exit_done;
    }
    Session session;
    if (program.empty()) {
        const auto bus = session.bus_of(*device);
        const auto has = bus ? stored(**bus, *device) : std::unexpected(bus.error());
        if (!has)
            return std::unexpected(has.error());
        if (*has == 0) {
            tell(words, *device, program, false);
            return exit_done;
        }
    }
    const auto yes = confirm(words, question(*device, program));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    return upload(words, **bus, *device, *asked, program);
}

} // namespace

Verb motion_upload_verb()
{
    return {
        .name = "motion upload",
        .says = "Store a self-running program in a SAM.",
        .arguments = {target_argument,
                      {"FILE", "the text of the program, as for sinew motion assemble; - is stdin", false}},
        .options = with_device_options(
            {{"--none", "", "switch the stored program off instead"}, dry_run_option, yes_option, json_option}),
        .examples = {{"sinew motion upload elbow wave.motion --robot arm.toml --dry-run", "the bytes"},
                     {"sinew motion upload elbow wave.motion --robot arm.toml --sim --yes", "a simulated one"},
                     {"sinew motion upload elbow --none --robot arm.toml", "asks first"}},
        .run = run,
        .acts = true,
        .more =
            "The servo runs it at once and whenever it has power, with nobody at its bus; a motion command stops "
            "it until then. Try it first: sinew motion simulate. A program that would take a joint beyond the limits "
            "of its robot file is refused. No device gives its program back, so it is written whether it is there "
            "already or not; --none writes nothing where there is none."};
}

} // namespace sinew::cli
