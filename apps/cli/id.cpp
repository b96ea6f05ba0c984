#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/presence.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

struct Change {
    wire::Request request;
    int new_id = -1;
};

std::expected<Change, Error> change_from(const Words& words, const Device& device)
{
    const Family& family = *device.family;
    const auto new_id = words.number("NEW-ID", family.ids.low, family.ids.high);
    if (!new_id)
        return std::unexpected(new_id.error());
    if (!family.ids.contains(device.id))
        return fail(Errc::bad_id, fmt::format("id {} is every device of the line, and would give them all one id; name "
                                              "the one whose id is to change",
                                              device.id));
    const auto* message = device.line().find("set-id");
    if (message == nullptr)
        return fail(Errc::unsupported, fmt::format("{} has no message that sets an id on the firmware line {}; its id "
                                                   "is set by switches or with the vendor's tool",
                                                   family.name, device.line().name));
    const std::string word = fmt::format("new_id={}", **new_id);
    auto asked = request_from(device, *message, {&word, 1});
    if (!asked)
        return std::unexpected(asked.error());
    return Change{.request = *asked, .new_id = static_cast<int>(**new_id)};
}

Outcome done(const Words& words, const Device& device, int new_id, bool changed)
{
    if (words.json())
        print(Json::object({{"device", device.name},
                            {"family", device.family->name},
                            {"link", device.link},
                            {"old_id", device.id},
                            {"id", new_id},
                            {"changed", changed}}));
    else
        fmt::print("{} {} id {}\n", device.name, changed ? "answers at" : "has the", new_id);
    if (changed && device.joint != nullptr)
        fmt::print(stderr, "Write id = {} under [joint.{}] of {}: it says {} yet.\n", new_id, device.name,
                   device.file->path, device.id);
    return exit_done;
}

/// At the new id, else at the old one: what is true is said either way.
Outcome verify(const Words& words, bus::Bus& bus, const Device& device, int new_id)
{
    const auto at_new = somebody_at(bus, device, new_id);
    if (!at_new)
        return std::unexpected(at_new.error());
    const auto at_old = somebody_at(bus, device, device.id);
    if (!at_old)
        return std::unexpected(at_old.error());
    if (*at_new && !*at_old) {
        move_flash_writes(device, new_id);
        return done(words, device, new_id, true);
    }
    if (*at_new)
        return fail(Errc::bad_reply,
                    fmt::format("both id {} and id {} answer now: two devices had the id {}, and one of them kept it",
                                device.id, new_id, device.id));
    if (*at_old)
        return fail(Errc::unsupported,
                    fmt::format("{} still answers at id {} and not at {}: it has not taken the id, or takes it when it "
                                "is switched on next",
                                device.name, device.id, new_id));
    return fail(Errc::timeout, fmt::format("{} answers neither at id {} nor at {} any more; sinew scan {} looks at all "
                                           "ids",
                                           device.name, new_id, device.id, device.link));
}

Outcome run(const Words& words)
{
    const auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const auto change = change_from(words, *device);
    if (!change)
        return std::unexpected(change.error());
    const int new_id = change->new_id;
    if (words.has("--dry-run")) {
        show_unsent(words, *device, {&change->request, 1});
        return exit_done;
    }
    if (new_id != device->id) {
        const auto yes = confirm(words, fmt::format("{} will answer at id {} instead of {}, which writes its flash",
                                                    device->name, new_id, device->id));
        if (!yes)
            return std::unexpected(yes.error());
        if (!*yes)
            return exit_refused;
    }
    Session session;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    const auto there = ask(**bus, *probe(*device, device->id));
    if (!there)
        return std::unexpected(there.error());
    if (new_id == device->id)
        return done(words, *device, new_id, false);
    const auto taken = somebody_at(**bus, *device, new_id);
    if (!taken)
        return std::unexpected(taken.error());
    if (*taken)
        return fail(Errc::unsupported,
                    fmt::format("id {} is taken: somebody answers there, and two devices of one id talk at the same "
                                "time; nothing was written",
                                new_id));
    if (auto sent = write_once(**bus, *device, change->request); !sent)
        return std::unexpected(sent.error());
    return verify(words, **bus, *device, new_id);
}

} // namespace

Verb id_verb()
{
    return {.name = "id",
            .says = "Give a device another id, and see that it answers there.",
            .arguments = {target_argument, {"NEW-ID", "the id that it shall have"}},
            .options = with_device_options({dry_run_option, yes_option, json_option}),
            .examples = {{"sinew id elbow 9 --robot arm.toml", "asks first"},
                         {"sinew id serial:/dev/ttyUSB0 3 --family sam --id 0 --yes", "a new servo, as delivered"},
                         {"sinew id waist_yaw 9 --robot arm.toml --sim --yes", "a simulated one"}},
            .run = run,
            .acts = true,
            .more = "The id is stored in flash. Nothing is written where somebody answers at the new id already. "
                    "Afterwards the device is looked for at the new id and, if it is not there, at the old one. "
                    "RMD motors have no such message."};
}

} // namespace sinew::cli
