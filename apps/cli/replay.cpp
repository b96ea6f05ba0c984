#include "apps/cli/exit_codes.hpp"
#include "apps/cli/recording.hpp"
#include "apps/cli/screen.hpp"
#include "apps/cli/session.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <utility>

namespace sinew::cli {
namespace {

using record::Topic;

std::string_view to_word(Topic topic)
{
    return topic == Topic::state ? "state" : topic == Topic::command ? "command" : "event";
}

std::string line_of(const Recorded& one)
{
    std::string out = one.topic == Topic::event ? "event" : fmt::format("{} {}", one.name, to_word(one.topic));
    std::string_view before = ": ";
    for (const auto& column : record::columns_of(one.topic))
        if (const auto text = text_of(one.fields, column); !text.empty())
            out += fmt::format("{}{} {}", std::exchange(before, ", "), column.name, text);
    return out;
}

Json json_of(const Recorded& one)
{
    Json out = Json::object({{"kind", to_word(one.topic)}});
    if (one.topic != Topic::event)
        out.set("joint", one.name);
    for (const auto& column : record::columns_of(one.topic)) {
        if (const auto* text = one.fields.text(column.name))
            out.set(column.name, *text);
        if (const auto number = one.fields.number(column.name))
            out.set(column.name, *number);
        if (const auto flag = one.fields.flag(column.name))
            out.set(column.name, *flag);
    }
    return out;
}

struct Wanted {
    bool frames = true, joints = true;
    std::span<const std::string> names; ///< of joints; empty: all
};

std::expected<Listener, Error> listener_for(const Words& words)
{
    std::vector<Device> devices;
    if (const auto path = words.text("--robot")) {
        auto known = devices_in(*path);
        if (!known)
            return std::unexpected(known.error());
        devices = std::move(*known);
    }
    DecodeOptions options{.profile = words.text("--profile").value_or(""), .model = words.text("--model").value_or("")};
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        options.family = *family;
    }
    return Listener::make(std::move(options), std::move(devices));
}

Outcome run(const Words& words)
{
    if (words.has("--frames") && words.has("--states"))
        return fail(Errc::bad_argument, "--frames and --states exclude each other; without both everything is shown");
    const auto count = words.number("--count", 1, std::numeric_limits<std::int64_t>::max());
    if (!count)
        return std::unexpected(count.error());
    auto filter = filter_from(words, nullptr);
    if (!filter)
        return std::unexpected(filter.error());
    auto listener = listener_for(words);
    if (!listener)
        return std::unexpected(listener.error());
    const bool only_frames =
        !filter->ids.empty() || !filter->messages.empty() || filter->errors || words.has("--frames");
    const auto joints = words.all("--joint");
    const Wanted wanted{.frames = !words.has("--states") && joints.empty(), .joints = !only_frames, .names = joints};
    const auto most = *count ? static_cast<std::uint64_t>(**count) : ~std::uint64_t{0};
    Screen screen(words, std::move(*filter));
    catch_interrupts();
    const auto show = [&](const Heard& heard) {
        if (screen.shown() < most)
            screen.show(heard);
    };
    std::optional<Error> problem;
    std::set<std::string> seen;
    const auto outcome = read_recording(*words.text("FILE"), [&](const Recorded& one) {
        if (one.topic == Topic::frame) {
            const auto frame = record::frame_from(*one.message);
            if (!frame)
                problem = frame.error();
            else if (wanted.frames)
                listener->hear(*frame, show);
            return screen.shown() < most && !problem;
        }
        seen.insert(one.name);
        if (wanted.joints &&
            (wanted.names.empty() || std::ranges::find(wanted.names, one.name) != wanted.names.end())) {
            screen.show(one.at, line_of(one), json_of(one));
        }
        return screen.shown() < most && !problem;
    });
    if (!outcome)
        return outcome;
    if (problem)
        return std::unexpected(*problem);
    listener->fall_silent(show);
    if (screen.shown() < most && !interrupted())
        if (auto there = check_names("joint", *words.text("FILE"), joints, seen); !there)
            return std::unexpected(there.error());
    return outcome;
}

} // namespace

Verb replay_verb()
{
    return {.name = "replay",
            .says = "Show what is in a recording: decoded frames, states, commands and events, with their times.",
            .arguments = {recording_argument},
            .options = {{"--frames", "", "show frames only"},
                        {"--states", "", "show states, commands and events only"},
                        joint_option,
                        show_id_option,
                        show_message_option,
                        errors_option,
                        absolute_option,
                        {"--count", "N", "end after so many lines"},
                        {"--robot", "FILE", "the robot file, for the scales of its devices"},
                        {"--family", "F", "sam, nuri or rmd; that of the recording where it is not given"},
                        model_option,
                        profile_option,
                        {"--json", "", "print one object per line"}},
            .examples = {{"sinew replay run.mcap", "everything"},
                         {"sinew replay run.mcap --joint elbow", "what one joint was told and did"},
                         {"sinew replay run.mcap --errors --absolute", "what went wrong on the wires, and when"},
                         {"sinew get replay:run.mcap#left input-voltage --family sam --id 3 --model SAM-160EO200",
                          "ask the recording"}},
            .run = run,
            .more =
                "As a link, replay:FILE#BUS answers requests as the devices did. sinew sniff --replay reads the frames "
                "of other formats as well.",
            .ends = {exit_refused, exit_interrupted}};
}

} // namespace sinew::cli
