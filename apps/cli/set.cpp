#include "apps/cli/names.hpp"
#include "apps/cli/transact.hpp"

namespace sinew::cli {
namespace {

Outcome run(const Words& words)
{
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    const auto message = setter_named(*device, *words.text("NAME"));
    if (!message)
        return std::unexpected(message.error());
    return transact(words, std::move(*device), **message, words.all("FIELD=VALUE"), true);
}

} // namespace

Verb set_verb()
{
    return {.name = "set",
            .says = "Set something of a device.",
            .arguments = {target_argument,
                          {"NAME", "what to set, such as pd-gain: a message without its set- or write-"},
                          {"FIELD=VALUE", "the new values", false, true}},
            .options =
                with_device_options({{"--dry-run", "", "show the bytes and send nothing"}, yes_option, json_option}),
            .examples = {{"sinew set elbow runtime-pd-gain p_gain=30 d_gain=20 --robot arm.toml", "until power-off"},
                         {"sinew set serial:/dev/ttyUSB0 id new_id=3 --family sam --id 1 --yes", "stored in flash"}},
            .run = run,
            .acts = true,
            .more = "What moves or writes flash asks first, and needs --yes where there is no terminal. A setting that "
                    "the device has already is not written again: flash wears out."};
}

} // namespace sinew::cli
