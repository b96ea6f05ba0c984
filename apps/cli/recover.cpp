#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/new_file.hpp"
#include "sinew/record/recovery.hpp"

#include <array>
#include <fmt/format.h>
#include <fstream>
#include <utility>

namespace sinew::cli {
namespace {

/// run.mcap becomes run.recovered.mcap.
std::filesystem::path place_for(const Words& words, const std::filesystem::path& from)
{
    if (const auto out = words.text("--out"))
        return *out;
    auto name = from.stem();
    name += ".recovered.mcap";
    return from.parent_path() / name;
}

std::expected<void, Error> pass_on(record::Recovery& recovery, NewFile& out)
{
    auto written = out.write(recovery.pending());
    recovery.written();
    return written;
}

std::expected<void, Error> recover(const std::string& path, std::ifstream& in, record::Recovery& recovery, NewFile& out)
{
    std::array<char, 256 * 1024> piece;
    while (in) {
        in.read(piece.data(), piece.size());
        recovery.feed(record::bytes_of({piece.data(), static_cast<std::size_t>(in.gcount())}));
        if (auto written = pass_on(recovery, out); !written)
            return written;
    }
    if (auto ended = recovery.end(); !ended)
        return fail(ended.error().code, fmt::format("{}, {}", path, ended.error().detail));
    return pass_on(recovery, out);
}

Outcome run(const Words& words)
{
    const std::string from = *words.text("FILE");
    const auto to = place_for(words, from);
    std::error_code none;
    std::ifstream in(from, std::ios::binary);
    if (!in || std::filesystem::is_directory(from, none))
        return fail(Errc::bad_file, fmt::format("'{}' cannot be read", from));
    if (std::filesystem::equivalent(from, to, none))
        return fail(Errc::bad_argument, "a recording cannot be written over while it is read; give another --out");
    auto out = NewFile::make(to);
    if (!out)
        return std::unexpected(out.error());
    record::Recovery recovery;
    if (auto recovered = recover(from, in, recovery, *out); !recovered)
        return std::unexpected(recovered.error());
    const bool was_whole = recovery.problems().empty();
    if (!was_whole)
        if (auto kept = out->keep(); !kept)
            return std::unexpected(kept.error());
    const auto& count = recovery.count();
    if (words.json()) {
        Json problems = Json::array();
        for (const auto& problem : recovery.problems())
            problems.add(problem.detail);
        print(Json::object({{"file", was_whole ? Json() : Json(to.string())},
                            {"was_whole", was_whole},
                            {"messages", static_cast<std::int64_t>(count.messages)},
                            {"attachments", static_cast<std::int64_t>(count.attachments)},
                            {"metadata", static_cast<std::int64_t>(count.metadata)},
                            {"problems", std::move(problems)}}));
        return exit_done;
    }
    std::string told; // one damage may spoil several records
    for (const auto& problem : recovery.problems())
        if (std::exchange(told, problem.detail) != problem.detail)
            fmt::print(stderr, "{}, {}\n", from, problem.detail);
    if (was_whole)
        fmt::print("{} is whole: {} messages; nothing was written\n", from, count.messages);
    else
        fmt::print("{} messages and {} attachment{} are in {}\n", count.messages, count.attachments,
                   count.attachments == 1 ? "" : "s", to.string());
    return exit_done;
}

} // namespace

Verb recover_verb()
{
    return {.name = "recover",
            .says = "Make a whole recording of one that was cut off or damaged: all that can be read is kept.",
            .arguments = {{"FILE", "an MCAP file"}},
            .options = {{"--out", "FILE", "where to; FILE.recovered.mcap where it is not given"}, json_option},
            .examples = {{"sinew recover run.mcap", "writes run.recovered.mcap"},
                         {"sinew recover run.mcap --out whole.mcap --json", "for a program"}},
            .run = run,
            .more = "FILE stays as it is. Of a chunk whose checksum does not fit nothing is kept.",
            .ends = {exit_interrupted}};
}

} // namespace sinew::cli
