#include "apps/cli/readings.hpp"

#include "apps/cli/exit_codes.hpp"
#include "apps/cli/names.hpp"

#include <fmt/format.h>

namespace sinew::cli {

std::expected<std::vector<wire::Request>, Error> all_reads(const Device& device)
{
    std::vector<wire::Request> out;
    for (const auto* message : device.line().messages) {
        if (!asks_nothing(device, *message) || message->name().starts_with("quick-"))
            continue;
        const auto one = request(device, *message, {});
        if (!one)
            return std::unexpected(one.error());
        out.push_back(*one);
    }
    return out;
}

std::vector<Read> read_all(const Device& device, bus::Bus& bus, std::span<const wire::Request> requests)
{
    std::vector<Read> out;
    for (const auto& asked : requests) {
        auto values = ask(bus, asked);
        const bool lost = !values && (values.error().code == Errc::link_lost || values.error().code == Errc::stopped);
        if (values)
            out.push_back({asked.message, show(device, *asked.message, *values)});
        else
            out.push_back({asked.message, std::unexpected(about(device, values.error()))});
        if (lost)
            break;
    }
    return out;
}

Json to_json(const std::vector<Read>& readings)
{
    Json out = Json::array();
    for (const auto& read : readings) {
        Json one = Json::object({{"message", read.message->name()}, {"name", reads_what(*read.message)}});
        if (read.values)
            one.set("values", to_json(*read.values));
        else
            one.set("error", Json::object({{"code", to_word(read.values.error().code)},
                                           {"sentence", to_sentence(read.values.error())}}));
        out.add(std::move(one));
    }
    return out;
}

Outcome print_readings(const Words& words, const Device& device, const std::vector<Read>& readings)
{
    Table table({"NAME", "FIELD", "RAW", "VALUE"});
    int code = exit_done;
    for (const auto& read : readings) {
        auto name = reads_what(*read.message).value_or(std::string(read.message->name()));
        if (!read.values) {
            fmt::print(stderr, "sinew: {}\n", to_sentence(read.values.error()));
            code = code == exit_done ? exit_code(read.values.error().code) : code;
            continue;
        }
        for (const auto& v : *read.values) {
            table.add({std::exchange(name, ""), std::string(v.name), std::to_string(v.raw),
                       v.value || !v.label.empty() ? text(v) : ""});
        }
    }
    if (words.json())
        print(Json::object({{"device", device.name},
                            {"family", device.family->name},
                            {"id", device.id},
                            {"readings", to_json(readings)}}));
    else if (!table.empty())
        fmt::print("{}", table.text());
    return code;
}

} // namespace sinew::cli
