#include "apps/cli/exit_codes.hpp"
#include "apps/cli/fields.hpp"
#include "apps/cli/names.hpp"
#include "apps/cli/present.hpp"
#include "apps/cli/readings.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

Outcome list(const Words& words, const Device& device)
{
    Json out = Json::array();
    for (const auto* message : device.line().messages)
        if (const auto what = reads_what(*message)) {
            if (words.json())
                out.add(*what);
            else
                fmt::print("{}\n", *what);
        }
    if (words.json())
        print(out);
    return exit_done;
}

/// NAME words read; FIELD=VALUE words belong to the name before them.
std::expected<std::vector<wire::Request>, Error> requests(const Device& device, std::span<const std::string> words)
{
    std::vector<wire::Request> out;
    for (std::size_t i = 0; i < words.size();) {
        const auto message = reader_named(device, words[i]);
        if (!message)
            return std::unexpected(message.error());
        std::size_t end = i + 1;
        while (end < words.size() && words[end].find('=') != std::string::npos)
            ++end;
        const auto values = values_from(device, **message, words.subspan(i + 1, end - i - 1));
        if (!values)
            return std::unexpected(values.error());
        const auto one = request(device, **message, *values);
        if (!one)
            return std::unexpected(one.error());
        out.push_back(*one);
        i = end;
    }
    return out;
}

Outcome run(const Words& words)
{
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (!words.has("NAME"))
        return list(words, *device);
    if (const auto fine = requests(*device, words.all("NAME")); !fine)
        return std::unexpected(fine.error());
    Session session;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    if (auto found = find_model(*device, **bus); !found)
        return std::unexpected(found.error());
    const auto asked = requests(*device, words.all("NAME"));
    if (!asked)
        return std::unexpected(asked.error());
    const auto readings = read_all(*device, **bus, *asked);
    return print_readings(words, *device, readings);
}

} // namespace

Verb get_verb()
{
    return {.name = "get",
            .says = "Read something of a device by name; without a name, list what can be read.",
            .arguments = {target_argument,
                          {"NAME", "what to read, such as input-voltage: a message without its read- or request-",
                           false, true}},
            .options = with_device_options({json_option}),
            .examples = {{"sinew get elbow input-voltage --robot arm.toml", "the supply voltage"},
                         {"sinew get slcan:/dev/ttyACM0 status1 parameter param_id=speed_pid --family rmd --id 1",
                          "two readings; FIELD=VALUE goes with the name before it"}},
            .run = run};
}

} // namespace sinew::cli
