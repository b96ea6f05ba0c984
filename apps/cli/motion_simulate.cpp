#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/measured_step.hpp"
#include "apps/cli/motion_file.hpp"
#include "apps/cli/moving.hpp"
#include "apps/cli/plot.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration default_length = std::chrono::seconds(5);
constexpr Duration period = std::chrono::milliseconds(20);

std::expected<std::vector<Json>, Error> watch(Session& session, Driven& driven, Duration length, Plot& plot)
{
    std::vector<Json> lines;
    const TimePoint begin = session.clock().now();
    for (TimePoint next = begin; next - begin <= length && !interrupted(); next += period) {
        wait_until(session, next);
        if (auto read = read_state(driven, actuator::Depth::full); !read)
            return std::unexpected(read.error());
        if (const auto here = position_of(driven)) {
            plot.x.push_back(seconds(next - begin));
            plot.panels.front().y.push_back(units::deg(*here));
        }
        lines.push_back(state_json(driven, next - begin));
    }
    return lines;
}

Outcome run(const Words& words)
{
    const auto program = read_motion(*words.text("FILE"));
    if (!program)
        return std::unexpected(program.error());
    const auto length = words.duration("--for");
    if (!length)
        return std::unexpected(length.error());
    Words simulated = words;
    simulated.add("--sim", "");
    auto device = target(simulated);
    if (!device)
        return std::unexpected(device.error());
    const auto asked = motion_request(*device, program->instructions);
    if (!asked)
        return std::unexpected(asked.error());
    if (const auto within = check_motion(*device, *program); !within)
        fmt::print(stderr, "sinew: this would not be uploaded: {}\n", to_sentence(within.error()));
    Session session;
    auto driven = drive_and_read(session, std::move(*device));
    if (!driven)
        return std::unexpected(driven.error());
    if (const auto sent = ask(*driven->bus, *asked); !sent)
        return std::unexpected(sent.error());
    Plot plot{.panels = {{.label = fmt::format("position of {} in deg", driven->device.name)}}};
    const auto lines = watch(session, *driven, length->value_or(default_length), plot);
    if (!lines)
        return std::unexpected(lines.error());
    if (words.json())
        for (const auto& line : *lines)
            print_line(line);
    else
        fmt::print("{}", text_plot(plot.x, plot.panels.front(), columns(), 16));
    return exit_done;
}

} // namespace

Verb motion_simulate_verb()
{
    return {
        .name = "motion simulate",
        .says = "Let a simulated SAM run a program, and show how it moves.",
        .arguments = {{"TARGET", "a joint of the robot file, which is simulated"},
                      {"FILE", "the text of the program, as for sinew motion assemble; - is stdin"}},
        .options = {robot_option,
                    {"--for", "TIME", "how long; 5s where it is not given"},
                    {"--json", "", "print one object per look and line"}},
        .examples = {{"sinew motion simulate elbow wave.motion --robot arm.toml", "a picture"}},
        .run = run,
        .more =
            "In virtual time; no device is touched. What the document leaves open about programs are options of the "
            "robot file (motion_wrap, motion_repeat)."};
}

} // namespace sinew::cli
