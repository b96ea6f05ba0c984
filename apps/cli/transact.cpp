#include "apps/cli/transact.hpp"

#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/present.hpp"

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

} // namespace

Outcome transact(const Words& words, Device device, const wire::MessageInfo& message,
                 std::span<const std::string> field_words)
{
    if (!message.request.exists())
        return fail(Errc::unsupported, fmt::format("{} is an answer; devices send it, hosts do not", message.name()));
    const bool dry = words.has("--dry-run");
    Session session;
    auto values = values_from(device, message, field_words);
    if (!values)
        return std::unexpected(values.error());
    auto asked = request(device, message, *values);
    if (!asked)
        return std::unexpected(asked.error());
    note_what_the_manual_advises(*values);
    Json out = Json::object({{"device", device.name}, {"message", message.name()}});
    wire::Frame reply;
    if (!dry) {
        if (const auto what = danger(device, message); !what.empty()) {
            const auto yes = confirm(words, what);
            if (!yes)
                return std::unexpected(yes.error());
            if (!*yes)
                return exit_refused;
        }
        const auto bus = session.bus_of(device);
        if (!bus)
            return std::unexpected(bus.error());
        if (auto found = find_model(device, **bus); !found)
            return std::unexpected(found.error());
        // Ranges and scales that depend on the model are known only now.
        if (values = values_from(device, message, field_words); !values)
            return std::unexpected(values.error());
        if (asked = request(device, message, *values); !asked)
            return std::unexpected(asked.error());
        bus::Result result;
        if (auto sent = (*bus)->exchange({&*asked, 1}, {&result, 1}); !sent)
            return std::unexpected(sent.error());
        if (const auto got = result.reply(); !got)
            return std::unexpected(got.error());
        else
            reply = *got;
    }
    const bool has_reply = !dry && asked->answered;
    wire::Values said;
    if (has_reply) {
        const auto decoded = reply_values(*asked, reply);
        if (!decoded)
            return std::unexpected(decoded.error());
        said = *decoded;
    }
    if (words.json()) {
        out.set("sent", !dry);
        out.set("request", frame_json(device, message, asked->frame, *values));
        out.set("reply", has_reply ? frame_json(device, message, reply, said) : Json());
        print(out);
        return exit_done;
    }
    const bool can = device.family->can;
    fmt::print("{}  {}\n", bold(dry ? "would send" : "sent"), to_text(asked->frame, can));
    print_values(device, message, *values);
    if (has_reply) {
        fmt::print("{}  {}\n", bold("answer"), to_text(reply, can));
        print_values(device, message, said);
    } else if (!dry) {
        fmt::print(stderr, "No answer is due.\n");
    }
    return exit_done;
}

} // namespace sinew::cli
