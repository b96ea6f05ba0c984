#include "apps/cli/presence.hpp"

#include "apps/cli/present.hpp"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<wire::Request, Error> probe(const Device& like, int id)
{
    auto asked = like.family->protocol->probe(id);
    if (!asked)
        return std::unexpected(asked.error());
    asked->options = like.options();
    asked->response_time = like.response_time();
    return asked;
}

std::expected<bool, Error> somebody_at(bus::Bus& bus, const Device& like, int id)
{
    const auto asked = probe(like, id);
    if (!asked)
        return std::unexpected(asked.error());
    const auto answer = ask(bus, *asked);
    if (answer)
        return true;
    const Errc code = answer.error().code;
    if (code == Errc::timeout)
        return false;
    if (code >= Errc::bad_length && code <= Errc::bad_reply)
        return true;
    return std::unexpected(answer.error());
}

void show_unsent(const Words& words, const Device& device, std::span<const wire::Request> requests)
{
    const bool can = device.family->can;
    Json out = Json::array();
    for (const auto& one : requests) {
        const auto values = wire::decode(*one.message, wire::Direction::request, one.frame, one.options);
        const auto shown = values ? show(device, *one.message, values->values) : std::vector<Shown>{};
        if (words.json()) {
            Json object = Json::object({{"device", device.name}, {"message", one.message->name()}, {"sent", false}});
            object.set("bytes", to_text({.size = one.frame.size, .data = one.frame.data}, false));
            if (can)
                object.set("can_id", one.frame.can_id);
            object.set("values", to_json(shown));
            out.add(std::move(object));
            continue;
        }
        fmt::print("{}  {}  {}\n", bold("would send"), to_text(one.frame, can), one.message->name());
        if (const auto table = table_of(shown); !table.empty())
            fmt::print("{}", table.text(2));
    }
    if (words.json())
        print(out);
}

} // namespace sinew::cli
