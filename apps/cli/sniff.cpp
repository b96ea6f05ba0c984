#include "apps/cli/exit_codes.hpp"
#include "apps/cli/screen.hpp"
#include "apps/cli/source.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

namespace sinew::cli {
namespace {

/// What the words say of the bus; of a replay only the family and the robot file's devices.
std::expected<BusTarget, Error> target_of(const Words& words)
{
    if (!words.has("--replay")) {
        if (!words.has("BUS"))
            return fail(Errc::bad_argument, "which bus? Name a link, a bus with --robot, or --replay FILE");
        Words without_ids; // --id is a filter here
        for (const auto* name : {"BUS", "--robot", "--link", "--family", "--model", "--profile"})
            for (const auto& value : words.all(name))
                without_ids.add(name, value);
        return bus_target(without_ids);
    }
    if (words.has("BUS"))
        return fail(Errc::bad_argument, "a bus and --replay exclude each other");
    BusTarget out;
    if (const auto name = words.text("--family")) {
        const auto family = family_named(*name);
        if (!family)
            return std::unexpected(family.error());
        out.family = *family;
    }
    if (const auto path = words.text("--robot")) {
        auto devices = devices_in(*path);
        if (!devices)
            return std::unexpected(devices.error());
        out.devices = std::move(*devices);
    }
    return out;
}

std::expected<std::optional<record::FileWriter>, Error> file_for(const Words& words)
{
    const auto path = words.text("--write");
    if (!path)
        return std::nullopt;
    if (words.text("--replay") == path)
        return fail(Errc::bad_argument, "a recording cannot be written over while it is read");
    auto file = record::FileWriter::create(*path);
    if (!file)
        return std::unexpected(file.error());
    return std::optional(std::move(*file));
}

/// `heard`: how many frames there were, shown or not.
Outcome listen(Source& source, Listener& listener, Screen& screen, record::FileWriter* file,
               std::optional<Duration> time, std::uint64_t count, std::uint64_t& heard)
{
    const link::RealClock clock;
    const TimePoint end = time ? clock.now() + *time : TimePoint::max();
    const auto use = [&](const Heard& one) {
        if (screen.shown() < count)
            screen.show(one);
    };
    int code = exit_done;
    while (!interrupted() && !source.over && screen.shown() < count && clock.now() < end) {
        const auto one = source.next(std::min<Duration>(Listener::silence, end - clock.now()));
        if (!one && one.error().code != Errc::bad_file)
            return std::unexpected(one.error());
        if (!one) {
            // What can be read behind a damaged place of a recording is read; what is none says so once.
            if (code == exit_done || heard > 0)
                fmt::print(stderr, "sinew: {}\n", to_sentence(one.error()));
            code = exit_code(one.error().code);
            continue;
        }
        if (!*one) {
            listener.fall_silent(use);
            if (auto flushed = file != nullptr ? file->flush() : std::expected<void, Error>{}; !flushed)
                return std::unexpected(flushed.error());
            continue;
        }
        if (auto added = file != nullptr ? file->add(**one) : std::expected<void, Error>{}; !added)
            return std::unexpected(added.error());
        ++heard;
        listener.hear(**one, use);
    }
    listener.fall_silent(use);
    if (auto flushed = file != nullptr ? file->flush() : std::expected<void, Error>{}; !flushed)
        return std::unexpected(flushed.error());
    return code;
}

Outcome run(const Words& words)
{
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    const auto count = words.number("--count", 1, std::numeric_limits<std::int64_t>::max());
    if (!count)
        return std::unexpected(count.error());
    auto target = target_of(words);
    if (!target)
        return std::unexpected(target.error());
    auto filter = filter_from(words, target->family);
    if (!filter)
        return std::unexpected(filter.error());
    auto listener = Listener::make({.family = target->family,
                                    .profile = words.text("--profile").value_or(""),
                                    .model = words.text("--model").value_or("")},
                                   std::move(target->devices));
    if (!listener)
        return std::unexpected(listener.error());
    const auto replayed = words.text("--replay");
    const auto source = replayed ? open_recording(*replayed) : open_live(*target);
    if (!source)
        return std::unexpected(source.error());
    auto file = file_for(words);
    if (!file)
        return std::unexpected(file.error());
    Screen screen(words, std::move(*filter));
    std::uint64_t heard = 0;
    const auto outcome = listen(**source, *listener, screen, *file ? &**file : nullptr, *time,
                                *count ? static_cast<std::uint64_t>(**count) : ~std::uint64_t{0}, heard);
    screen.summary();
    if (replayed && outcome && *outcome == exit_done && heard == 0 && !interrupted())
        return fail(Errc::bad_file, fmt::format("{} has no frames", *replayed == "-" ? "what came in" : *replayed));
    return outcome;
}

} // namespace

Verb sniff_verb()
{
    return {
        .name = "sniff",
        .says = "Show decoded traffic of a bus as it passes, until Ctrl-C. It only listens.",
        .arguments = {{bus_argument.name, bus_argument.says, false}},
        .options = {{"--replay", "FILE", "read a recording instead: MCAP, pcapng or a candump log; - is stdin"},
                    {"--write", "FILE", "keep everything: .mcap, .pcapng (Wireshark) or .log (candump, CAN only)"},
                    show_id_option,
                    show_message_option,
                    errors_option,
                    absolute_option,
                    {"--for", "TIME", "end after this time, such as 5s"},
                    {"--count", "N", "end after so many lines"},
                    robot_option,
                    link_option,
                    {"--family", "F", "sam, nuri or rmd; guessed where it is not given"},
                    model_option,
                    profile_option,
                    {"--json", "", "print one object per frame and line"}},
        .examples = {{"sinew sniff slcan:/dev/ttyACM0", "a CAN bus"},
                     {"sinew sniff serial:/dev/ttyUSB1?baud=1500000 --family sam --errors", "a second adapter"},
                     {"sinew sniff sim:robots/demo.toml#left", "a bus of the sinew sim that runs elsewhere"},
                     {"sinew sniff --replay run.pcapng --id 3", "a recording"},
                     {"sinew sniff --replay run.log --write run.pcapng >/dev/null", "for Wireshark"}},
        .run = run,
        .more =
            "-> was sent by the host, <- by a device. Where a line does not tell, the frame does, else the order: an "
            "answer follows its request. A port is opened by one program at a time, so listening to a serial line "
            "takes an adapter of its own."};
}

} // namespace sinew::cli
