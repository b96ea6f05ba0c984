#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/motion_file.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

Outcome run(const Words& words)
{
    const auto program = motion_from_hex(words.all("HEX"));
    if (!program)
        return std::unexpected(program.error());
    if (!words.json()) {
        fmt::print("{}", sam::disassemble(*program));
        return exit_done;
    }
    Json out = Json::array();
    for (const auto& instruction : *program) {
        auto line = sam::disassemble({&instruction, 1});
        line.pop_back();
        out.add(Json::object({{"bytes", motion_bytes({&instruction, 1})}, {"text", line}}));
    }
    print(out);
    return exit_done;
}

} // namespace

Verb motion_show_verb()
{
    return {.name = "motion show",
            .says = "Say what the bytes of a SAM's self-running program do.",
            .arguments = {{"HEX", "the bytes, two for each instruction", true, true}},
            .options = {json_option},
            .examples = {{"sinew motion show 10 52 31 0A 10 AC 31 0A", "the example of the manual"}},
            .run = run,
            .more =
                "The lines are those that sinew motion assemble reads. A device does not give its program back, only "
                "how many instructions it has (sinew get TARGET motion-data)."};
}

} // namespace sinew::cli
