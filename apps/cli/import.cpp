#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/recording.hpp"
#include "sinew/record/file.hpp"

#include <fmt/format.h>

namespace sinew::cli {
namespace {

Outcome run(const Words& words)
{
    const auto from = *words.text("LOG");
    const auto to = words.text("--out").value_or(beside(from, ".mcap"));
    const Family* family = nullptr;
    if (const auto name = words.text("--family")) {
        const auto named = family_named(*name);
        if (!named)
            return std::unexpected(named.error());
        family = *named;
    }
    std::error_code none;
    if (std::filesystem::equivalent(from, to, none))
        return fail(Errc::bad_argument, "a recording cannot be written over while it is read; give another --out");
    if (!words.has("--out") && std::filesystem::exists(to, none))
        return fail(Errc::bad_argument, fmt::format("{} is there already; name it with --out to write over it", to));
    if (std::filesystem::path(to).extension() != ".mcap")
        return fail(Errc::bad_argument, fmt::format("'{}' must end with .mcap", to));
    auto log = record::FileReader::open(from);
    if (!log)
        return std::unexpected(log.error());
    std::optional<record::FileWriter> file; // not before there is something to write
    std::int64_t frames = 0;
    std::optional<Error> problem;
    for (;;) {
        auto one = log->next();
        if (!one) {
            if (frames > 0 || problem)
                fmt::print(stderr, "sinew: {}\n", to_sentence(one.error()));
            problem = problem ? problem : one.error();
            continue;
        }
        if (!*one)
            break;
        auto& frame = **one;
        frame.bus = words.text("--bus").value_or(frame.bus);
        if (family != nullptr)
            frame.family = family->name;
        if (!file) {
            auto made = record::FileWriter::create(to);
            if (!made)
                return std::unexpected(made.error());
            file.emplace(std::move(*made));
        }
        if (auto added = file->add(frame); !added)
            return std::unexpected(added.error());
        ++frames;
    }
    if (!file)
        return problem ? std::unexpected(*problem) : fail(Errc::bad_file, fmt::format("{} has no frames", from));
    if (auto finished = file->finish(); !finished)
        return std::unexpected(finished.error());
    if (words.json())
        print(Json::object({{"file", to}, {"frames", frames}}));
    else
        fmt::print("{} frames are in {}\n", frames, to);
    return problem ? exit_code(problem->code) : exit_done;
}

} // namespace

Verb import_verb()
{
    return {.name = "import",
            .says = "Make a recording of a candump log or a pcapng file.",
            .arguments = {{"LOG", "the file, or - for stdin"}},
            .options = {{"--out", "FILE.mcap", "where to; LOG with the ending .mcap where it is not given"},
                        {"--bus", "NAME", "the name of its bus; that in the file where it is not given"},
                        {"--family", "F", "sam, nuri or rmd"},
                        json_option},
            .examples = {{"sinew import candump.log --family rmd --bus legs", "writes candump.mcap"},
                         {"candump -L can0 | sinew import - --out run.mcap", "what passes now"}},
            .run = run,
            .more = "Frames only: which values they carry is what sinew replay shows."};
}

} // namespace sinew::cli
