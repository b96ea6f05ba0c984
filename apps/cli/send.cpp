#include "apps/cli/transact.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

Outcome run(const Words& words)
{
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const auto message = message_named(*device->family, device->line(), *words.text("MESSAGE"));
    if (!message)
        return std::unexpected(message.error());
    return transact(words, std::move(*device), **message, words.all("FIELD=VALUE"));
}

} // namespace

Verb send_verb()
{
    return {.name = "send",
            .says = "Send any message by name, and show the bytes and what they mean.",
            .arguments = {target_argument,
                          {"MESSAGE", "its name, as `sinew messages` lists it"},
                          {"FIELD=VALUE", "its fields: numbers (12, 0x0C), words, or values with their unit (90deg)",
                           false, true}},
            .options =
                with_device_options({{"--dry-run", "", "show the bytes and send nothing"}, yes_option, json_option}),
            .examples = {{"sinew send serial:/dev/ttyUSB0 ping --family sam --id 1", "is it there?"},
                         {"sinew send slcan:/dev/ttyACM0 speed-closed-loop speed=90dps --family rmd --id 1 --dry-run",
                          "what would be sent"}},
            .run = run,
            .more = "What moves or writes flash asks first, and needs --yes where there is no terminal."};
}

} // namespace sinew::cli
