#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/motion_file.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

Outcome run(const Words& words)
{
    const auto program = read_motion(*words.text("FILE"));
    if (!program)
        return std::unexpected(program.error());
    const auto bytes = motion_bytes(program->instructions);
    if (words.json())
        print(Json::object(
            {{"instructions", static_cast<std::int64_t>(program->instructions.size())}, {"bytes", bytes}}));
    else
        fmt::print("{}\n", bytes);
    return exit_done;
}

} // namespace

Verb motion_assemble_verb()
{
    return {.name = "motion assemble",
            .says = "Make the bytes of a SAM's self-running program from a text.",
            .arguments = {{"FILE", "the text; - is stdin"}},
            .options = {json_option},
            .examples = {{"sinew motion assemble wave.motion", "the bytes"}},
            .run = run,
            .more = "An instruction a line: go POSITION [level N], wait TIME, until position|ad = > < >= <= N, wheel "
                    "cw|ccw N, passive, brake, outputs [1] [2]|none, repeat N|forever, end. Positions are quick "
                    "coordinates from 0 to 254 or angles from the middle, such as 45deg. Eight instructions at most; # "
                    "begins a comment."};
}

} // namespace sinew::cli
