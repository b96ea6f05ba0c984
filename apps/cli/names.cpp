#include "apps/cli/names.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/wire/select.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

/// The name without the word in it that says what is done.
std::optional<std::string> without(std::string_view name, std::initializer_list<std::string_view> verbs)
{
    for (const auto verb : verbs) {
        const auto at = name.find(verb);
        if (at == std::string_view::npos || (at != 0 && name[at - 1] != '-'))
            continue;
        std::string out(name.substr(0, at));
        out += name.substr(at + verb.size());
        constexpr std::string_view ending = "-feedback";
        if (out.size() > ending.size() && out.ends_with(ending))
            out.resize(out.size() - ending.size());
        return out;
    }
    return std::nullopt;
}

std::expected<const wire::MessageInfo*, Error> named(const Device& device, std::string_view name, std::string_view does,
                                                     std::optional<std::string> (*what)(const wire::MessageInfo&))
{
    std::vector<std::string> shorts;
    for (const auto* message : device.line().messages)
        if (const auto word = what(*message)) {
            if (*word == name || message->name() == name)
                return message;
            shorts.push_back(*word);
        }
    const std::vector<std::string_view> names(shorts.begin(), shorts.end());
    const auto near = did_you_mean(name, names);
    return fail(Errc::unknown_name,
                fmt::format("{} {} nothing called '{}'{}", device.family->name, does, name,
                            near.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : near));
}

} // namespace

std::optional<std::string> reads_what(const wire::MessageInfo& message)
{
    if (message.info.access != wire::Access::read || !message.request.exists() || !message.reply.exists())
        return std::nullopt;
    if (message.name() == "ping")
        return "ping";
    return without(message.name(), {"read-", "request-"});
}

std::optional<std::string> sets_what(const wire::MessageInfo& message)
{
    if (message.info.access == wire::Access::read || !message.request.exists())
        return std::nullopt;
    return without(message.name(), {"set-", "write-"});
}

std::expected<const wire::MessageInfo*, Error> reader_named(const Device& device, std::string_view name)
{
    return named(device, name, "reads", reads_what);
}

std::expected<const wire::MessageInfo*, Error> setter_named(const Device& device, std::string_view name)
{
    return named(device, name, "sets", sets_what);
}

bool asks_nothing(const Device& device, const wire::MessageInfo& message)
{
    if (device.spec && !offers(*device.spec, message))
        return false;
    return reads_what(message) && wire::value_fields(message.request, device.options()).all().empty() &&
           wire::request_ids(message).contains(device.id);
}

} // namespace sinew::cli
