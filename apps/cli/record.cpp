#include "apps/cli/exit_codes.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/record_reading.hpp"
#include "apps/cli/source.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

/// The buses that are listened to.
std::expected<std::vector<BusTarget>, Error> buses_from(const Words& words)
{
    std::vector<BusTarget> out;
    if (words.has("TARGET")) {
        Words bus;
        bus.add("BUS", *words.text("TARGET"));
        for (const auto* name : {"--robot", "--link", "--family", "--model", "--profile", "--sim"})
            for (const auto& value : words.all(name))
                bus.add(name, value);
        auto one = bus_target(bus);
        if (!one)
            return std::unexpected(one.error());
        out.push_back(std::move(*one));
        return out;
    }
    const auto path = robot_path(words);
    if (!path)
        return fail(Errc::bad_argument, "what is to be recorded? Name a link, or a robot file with --robot");
    auto all = buses_of(*path);
    if (!all)
        return std::unexpected(all.error());
    for (auto& bus : *all) {
        if (auto given = give_links(words, bus.devices); !given)
            return std::unexpected(given.error());
        bus.link = bus.devices.front().link;
    }
    return std::move(*all);
}

struct Ear {
    BusTarget target;
    std::unique_ptr<Source> source;
};

/// Takes what one source has; false: it has nothing more for now. The file comes into being with the first frame: where
/// nothing is heard an older one stays as it was.
std::expected<bool, Error> take(Ear& ear, std::optional<record::FileWriter>& file, const std::string& path,
                                std::uint64_t& frames)
{
    constexpr Duration patience = std::chrono::milliseconds(5);
    auto one = ear.source->next(patience);
    if (!one)
        return std::unexpected(one.error());
    if (!*one)
        return false;
    (*one)->bus = ear.target.name;
    if (ear.target.family != nullptr)
        (*one)->family = ear.target.family->name;
    if (!file) {
        auto made = record::FileWriter::create(path);
        if (!made)
            return std::unexpected(made.error());
        file.emplace(std::move(*made));
    }
    ++frames;
    if (auto added = file->add(**one); !added)
        return std::unexpected(added.error());
    return true;
}

Outcome listen(const Words& words, const std::string& path, std::optional<Duration> time)
{
    auto buses = buses_from(words);
    if (!buses)
        return std::unexpected(buses.error());
    std::vector<Ear> ears;
    for (auto& bus : *buses) {
        auto source = open_live(bus);
        if (!source)
            return std::unexpected(source.error());
        ears.push_back({std::move(bus), std::move(*source)});
    }
    if (auto writable = check_writable(path); !writable)
        return std::unexpected(writable.error());
    std::optional<record::FileWriter> file;
    const link::RealClock clock;
    const TimePoint begin = clock.now(), end = time ? begin + *time : TimePoint::max();
    TimePoint flush_at = begin;
    std::uint64_t frames = 0;
    std::expected<void, Error> good;
    while (good && !interrupted() && clock.now() < end &&
           !std::ranges::all_of(ears, [](const Ear& ear) { return ear.source->over; })) {
        for (auto& ear : ears)
            for (bool more = !ear.source->over; good && more && !interrupted();) {
                const auto taken = take(ear, file, path, frames);
                good = taken ? std::expected<void, Error>{} : std::unexpected(taken.error());
                more = taken && *taken && clock.now() < end;
            }
        if (good && file && clock.now() >= flush_at) {
            good = file->flush();
            flush_at = clock.now() + std::chrono::seconds(1);
        }
    }
    const auto finished = file ? file->finish() : std::expected<void, Error>{};
    if (!good || !finished)
        return std::unexpected(good ? finished.error() : good.error());
    if (!file && interrupted()) {
        fmt::print(stderr, "Nothing was heard, so {} was not written.\n", path);
        return exit_interrupted;
    }
    if (!file)
        return fail(Errc::timeout, fmt::format("nothing was heard, so {} was not written", path));
    const double seconds_passed = seconds(clock.now() - begin);
    if (words.json())
        print(Json::object(
            {{"file", path}, {"messages", static_cast<std::int64_t>(frames)}, {"time_s", seconds_passed}}));
    else
        fmt::print("{} frames in {:.3f} s are in {}\n", frames, seconds_passed, path);
    return exit_done;
}

Outcome run(const Words& words)
{
    const auto path = *words.text("FILE");
    if (std::filesystem::path(path).extension() != ".mcap")
        return fail(Errc::bad_argument,
                    fmt::format("'{}' must end with .mcap; write sinew record FILE.mcap [TARGET]", path));
    const auto time = words.duration("--for");
    if (!time)
        return std::unexpected(time.error());
    if (!words.has("--listen"))
        return record_reading(words, path, *time);
    if (words.has("--rate") || words.has("--id"))
        return fail(Errc::bad_argument, "--rate and --id say what is read; with --listen nothing is");
    return listen(words, path, *time);
}

} // namespace

Verb record_verb()
{
    return {.name = "record",
            .says = "Record a robot, a device or what passes on a bus until Ctrl-C.",
            .arguments = {{"FILE", "where to, FILE.mcap; a file that is there is written over"},
                          {"TARGET",
                           "a joint, or a link with --family and --id; with --listen a bus; without it all of --robot",
                           false}},
            .options = with_device_options(
                {{"--listen", "", "send nothing; record what others say"},
                 {"--rate", "HZ", "looks per second; as many as the wires allow where it is not given"},
                 {"--for", "TIME", "end after this time, such as 5s"},
                 {"--json", "", "print at the end what was recorded"}}),
            .examples = {{"sinew record run.mcap --robot arm.toml", "all joints, all buses at once"},
                         {"sinew record run.mcap serial:/dev/ttyUSB0 --family sam --id 1 --for 10s", "one device"},
                         {"sinew record run.mcap slcan:/dev/ttyACM0 --listen", "what passes on a bus"}},
            .run = run,
            .more = "First every device is asked what it is and how it is set. Then every bus is read at its own rate; "
                    "nothing moves. A file that is there stays as it is where nobody "
                    "answers. The file is whole at any moment: a second at most is "
                    "lost when the program is killed, and sinew recover completes the file."};
}

} // namespace sinew::cli
