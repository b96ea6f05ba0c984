#include "apps/cli/transact.hpp"

#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/present.hpp"
#include "sinew/family/settings.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// What a person must know before it is sent; empty: nothing.
std::string danger(const Device& device, const wire::MessageInfo& message)
{
    const auto& info = message.info;
    if (info.moves)
        return fmt::format("{} to {} can move the shaft or let it go", info.name, device.name);
    if (info.access == wire::Access::flash)
        return fmt::format("{} to {} writes its flash, which wears out", info.name, device.name);
    return {};
}

void note_what_the_manual_advises(const wire::Values& values)
{
    for (const auto& [field, raw] : values)
        if (field->recommended.given() && !field->recommended.contains(raw))
            fmt::print(stderr, "note: {} {} is outside what the manual recommends ({} … {})\n", field->name, raw,
                       field->recommended.low, field->recommended.high);
}

Json frame_json(const Device& device, const wire::MessageInfo& message, const wire::Frame& frame,
                const wire::Values& values)
{
    Json out = Json::object({{"bytes", to_text({.size = frame.size, .data = frame.data}, false)}});
    if (device.family->can)
        out.set("can_id", frame.can_id);
    out.set("values", to_json(show(device, message, values)));
    return out;
}

void print_values(const Device& device, const wire::MessageInfo& message, const wire::Values& values)
{
    const auto table = table_of(show(device, message, values));
    if (!table.empty())
        fmt::print("{}", table.text(2));
}

/// Request, and what came back.
struct Transaction {
    wire::Request asked;
    wire::Values values;
    std::optional<wire::Frame> reply;
    wire::Values said;
    bool spared = false; ///< the device has these values already
};

std::expected<Transaction, Error> prepare(const Device& device, const wire::MessageInfo& message,
                                          std::span<const std::string> field_words)
{
    const auto values = values_from(device, message, field_words);
    if (!values)
        return std::unexpected(values.error());
    const auto asked = request(device, message, *values);
    if (!asked)
        return std::unexpected(asked.error());
    return Transaction{.asked = *asked, .values = *values};
}

/// Whether the device says that it stores these values already.
std::expected<bool, Error> is_so(bus::Bus& bus, const Device& device, const wire::MessageInfo& message,
                                 const wire::Values& values)
{
    for (const auto& setting : settings_of(*device.family, device.line())) {
        // What is read is what counts now; where it can be tried until power-off that may be another value.
        if (setting.trial != nullptr || setting.write != &message || !setting.is_written_by(message, values) ||
            !device.family->ids.contains(device.id))
            continue;
        const auto asked = request(device, *setting.read, read_values(setting, device.options()));
        if (!asked)
            return std::unexpected(asked.error());
        if (!asked->answered || setting.info->decides_answers)
            return false;
        const auto said = ask(bus, *asked);
        if (!said)
            return std::unexpected(about(device, said.error()));
        return std::ranges::all_of(values, [&](const auto& one) { return said->find(one.field->name) == one.raw; });
    }
    return false;
}

/// Sends it to a device whose model it finds first, for ranges and scales depend on that.
std::expected<Transaction, Error> carry_out(Session& session, Device& device, const wire::MessageInfo& message,
                                            std::span<const std::string> field_words, bool spare_flash)
{
    const auto bus = session.bus_of(device);
    if (!bus)
        return std::unexpected(bus.error());
    if (auto found = find_model(device, **bus); !found)
        return std::unexpected(found.error());
    auto out = prepare(device, message, field_words);
    if (!out)
        return out;
    note_what_the_manual_advises(out->values);
    const bool stores = message.info.access == wire::Access::flash;
    if (stores && spare_flash) {
        const auto so = is_so(**bus, device, message, out->values);
        if (!so)
            return std::unexpected(so.error());
        out->spared = *so;
        if (*so)
            return out;
    }
    bus::Result result;
    if (auto sent = (*bus)->exchange({&out->asked, 1}, {&result, 1}); !sent)
        return std::unexpected(sent.error());
    const auto reply = result.reply();
    if (stores && (reply || reply.error().code >= Errc::timeout))
        count_flash_write(device);
    if (!reply)
        return std::unexpected(about(device, reply.error()));
    if (!out->asked.answered)
        return out;
    const auto said = reply_values(out->asked, *reply);
    if (!said)
        return std::unexpected(said.error());
    out->reply = *reply;
    out->said = *said;
    return out;
}

void print_transaction(const Words& words, const Device& device, const Transaction& done)
{
    const auto& message = *done.asked.message;
    const bool dry = words.has("--dry-run") || done.spared;
    if (words.json()) {
        print(Json::object({{"device", device.name},
                            {"message", message.name()},
                            {"sent", !dry},
                            {"request", frame_json(device, message, done.asked.frame, done.values)},
                            {"reply", done.reply ? frame_json(device, message, *done.reply, done.said) : Json()}}));
        return;
    }
    const bool can = device.family->can;
    fmt::print("{}  {}\n",
               bold(done.spared ? "not sent"
                    : dry       ? "would send"
                                : "sent"),
               to_text(done.asked.frame, can));
    print_values(device, message, done.values);
    if (done.reply) {
        fmt::print("{}  {}\n", bold("answer"), to_text(*done.reply, can));
        print_values(device, message, done.said);
    } else if (done.spared) {
        fmt::print(stderr, "It is so already; the flash was not written.\n");
    } else if (!dry) {
        fmt::print(stderr, "No answer is due.\n");
    }
}

} // namespace

Outcome transact(const Words& words, Device device, const wire::MessageInfo& message,
                 std::span<const std::string> field_words, bool spare_flash)
{
    if (!message.request.exists())
        return fail(Errc::unsupported, fmt::format("{} is an answer; devices send it, hosts do not", message.name()));
    const bool dry = words.has("--dry-run");
    if (!dry && message.info.access != wire::Access::read)
        if (auto live = check_live(device); !live)
            return std::unexpected(live.error());
    const auto prepared = prepare(device, message, field_words);
    // A value with its unit may need the model, which a device can be asked for.
    const bool model_may_help = !dry && !device.spec && !prepared && prepared.error().code == Errc::bad_argument &&
                                !prepared.error().field.empty();
    if (!prepared && !model_may_help)
        return std::unexpected(prepared.error());
    if (dry) {
        note_what_the_manual_advises(prepared->values);
        print_transaction(words, device, *prepared);
        return exit_done;
    }
    if (const auto what = danger(device, message); !what.empty()) {
        const auto yes = confirm(words, what);
        if (!yes)
            return std::unexpected(yes.error());
        if (!*yes)
            return exit_refused;
    }
    Session session;
    const auto done = carry_out(session, device, message, field_words, spare_flash);
    if (!done)
        return std::unexpected(done.error());
    print_transaction(words, device, *done);
    return exit_done;
}

} // namespace sinew::cli
