#include "apps/cli/exit_codes.hpp"
#include "apps/cli/flash_ledger.hpp"
#include "apps/cli/presence.hpp"
#include "apps/cli/readings.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

void print_head(const Device& device)
{
    fmt::print("{}\n", bold(device.name));
    const auto fact = [](std::string_view name, std::string_view value) {
        if (!value.empty())
            fmt::print("  {:<8}  {}\n", name, value);
    };
    fact("family", device.family->title);
    fact("model", device.model());
    fact("profile", device.line().name);
    fact("id", std::to_string(device.id));
    fact("link", device.link);
    if (const auto writes = flash_writes(device))
        fact("flash", fmt::format("written {} {} by this host; it may fail after {}", *writes,
                                  *writes == 1 ? "time" : "times", documented_flash_writes));
    fmt::print("\n");
}

Outcome run(const Words& words)
{
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    Session session;
    const auto bus = session.bus_of(*device);
    if (!bus)
        return std::unexpected(bus.error());
    // A device that is not there is told once, not once for every read.
    if (const auto asked = probe(*device, device->id); asked)
        if (const auto there = ask(**bus, *asked); !there)
            return std::unexpected(about(*device, there.error()));
    if (auto found = find_model(*device, **bus); !found)
        return std::unexpected(found.error());
    const auto asked = all_reads(*device);
    if (!asked)
        return std::unexpected(asked.error());
    const auto readings = read_all(*device, **bus, *asked);
    if (words.json()) {
        print(Json::object({{"device", device->name},
                            {"family", device->family->name},
                            {"model", device->model().empty() ? Json() : Json(device->model())},
                            {"profile", device->line().name},
                            {"id", device->id},
                            {"link", device->link},
                            {"flash_writes", flash_writes(*device)},
                            {"readings", to_json(readings)}}));
        return exit_done;
    }
    print_head(*device);
    if (!device->spec)
        fmt::print(stderr, "The device says a model that is not documented: values that depend on it stay raw.\n");
    return print_readings(words, *device, readings);
}

} // namespace

Verb info_verb()
{
    return {.name = "info",
            .says = "All that a device says of itself: model, firmware, settings and measurements.",
            .arguments = {target_argument},
            .options = with_device_options({json_option}),
            .examples = {{"sinew info elbow --robot arm.toml", "a joint of a robot file"},
                         {"sinew info serial:/dev/ttyUSB0?baud=1500000 --family sam --id 1", "a device on a link"}},
            .run = run};
}

} // namespace sinew::cli
