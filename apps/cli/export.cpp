#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/interrupt.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/new_file.hpp"
#include "apps/cli/recording.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/record/candump.hpp"
#include "sinew/record/pcapng.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <optional>
#include <utility>

namespace sinew::cli {
namespace {

using record::Topic;

/// stdout, or a file that is there when all of it is.
class Place
{
public:
    static std::expected<Place, Error> make(const Words& words, bool binary)
    {
        Place out;
        if (const auto path = words.text("--out")) {
            std::error_code none;
            if (std::filesystem::equivalent(*words.text("FILE"), *path, none))
                return fail(Errc::bad_argument,
                            "a recording cannot be written over by its own export; give another --out");
            auto file = NewFile::make(*path);
            if (!file)
                return std::unexpected(file.error());
            out.file_.emplace(std::move(*file));
        } else if (binary && stdout_is_terminal()) {
            return fail(Errc::bad_argument, "pcapng is nothing for a terminal; give --out FILE or pass it on");
        }
        return out;
    }
    /// The first error stays, and nothing is written after it.
    bool write(std::string_view text)
    {
        if (file_ && written_)
            written_ = file_->write(text);
        else if (!file_)
            fmt::print("{}", text);
        return written_.has_value();
    }
    std::expected<void, Error> keep()
    {
        if (file_ && written_)
            written_ = file_->keep();
        return written_;
    }

private:
    Place() = default;
    std::optional<NewFile> file_;
    std::expected<void, Error> written_;
};

bool is_wanted(const Words& words, std::string_view option, const std::string& name)
{
    const auto names = words.all(option);
    return names.empty() || std::ranges::find(names, name) != names.end();
}

std::string quoted(std::string text)
{
    if (text.find_first_of(",\"\n") == std::string::npos)
        return text;
    for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2)
        text.insert(at, 1, '"');
    return '"' + text + '"';
}

Outcome write_csv(const Words& words, Topic topic, Place& place, std::int64_t& rows)
{
    const bool joints = topic != Topic::event;
    const auto columns = record::columns_of(topic);
    std::string head = joints ? "time_s,joint" : "time_s";
    for (const auto& column : columns)
        head += fmt::format(",{}", column.name);
    head += '\n';
    std::set<std::string> seen;
    const auto outcome = read_recording(*words.text("FILE"), [&](const Recorded& one) {
        place.write(std::exchange(head, {})); // not before it is known that this is a recording
        if (one.topic != Topic::frame)
            seen.insert(one.name);
        if (one.topic != topic || !is_wanted(words, "--joint", one.name))
            return true;
        const auto since = one.at.time_since_epoch();
        const auto second = std::chrono::floor<std::chrono::seconds>(since);
        std::string line = fmt::format("{}.{:09}", second.count(), (since - second).count());
        if (joints)
            line += ',' + quoted(one.name);
        for (const auto& column : columns)
            line += ',' + quoted(text_of(one.fields, column));
        ++rows;
        return place.write(line + '\n');
    });
    if (outcome && place.write(head) && !interrupted()) // else not all of it was seen
        if (auto there = check_names("joint", *words.text("FILE"), words.all("--joint"), seen); !there)
            return std::unexpected(there.error());
    return outcome;
}

Outcome write_frames(const Words& words, record::Writer& writer, Place& place, std::int64_t& rows)
{
    std::optional<Error> problem;
    std::string text;
    std::set<std::string> seen;
    const auto outcome = read_recording(*words.text("FILE"), [&](const Recorded& one) {
        if (one.topic == Topic::frame)
            seen.insert(one.name);
        if (one.topic != Topic::frame || !is_wanted(words, "--bus", one.name))
            return true;
        const auto frame = record::frame_from(*one.message);
        auto added = frame ? writer.add(*frame, text) : std::unexpected(frame.error());
        if (!added)
            problem = added.error();
        const bool good = added && place.write(text);
        rows += good ? 1 : 0;
        text.clear();
        return good;
    });
    if (problem)
        return std::unexpected(*problem);
    if (outcome && !interrupted()) // else not all of it was seen
        if (auto there = check_names("bus", *words.text("FILE"), words.all("--bus"), seen); !there)
            return std::unexpected(there.error());
    return outcome;
}

std::expected<Topic, Error> topic_from(const Words& words)
{
    constexpr std::string_view names[] = {"states", "commands", "events"};
    const auto word = words.text("--of").value_or("states");
    const auto found = std::ranges::find(names, word);
    if (found == std::end(names))
        return fail(Errc::bad_argument,
                    fmt::format("--of takes {}, not '{}'{}", fmt::join(names, ", "), word, did_you_mean(word, names)));
    constexpr Topic topics[] = {Topic::state, Topic::command, Topic::event};
    return topics[found - std::begin(names)];
}

Outcome run(const Words& words)
{
    const auto format = words.text("--to").value_or("csv");
    constexpr std::string_view formats[] = {"csv", "candump", "pcapng"};
    if (std::ranges::find(formats, format) == std::end(formats))
        return fail(Errc::bad_argument, fmt::format("--to takes {}, not '{}'{}", fmt::join(formats, ", "), format,
                                                    did_you_mean(format, formats)));
    const auto topic = topic_from(words);
    if (!topic)
        return std::unexpected(topic.error());
    if (format != "csv" && (words.has("--of") || words.has("--joint")))
        return fail(Errc::bad_argument, "--of and --joint go with --to csv; for frames there is --bus");
    if (format == "csv" && words.has("--bus"))
        return fail(Errc::bad_argument, "--bus goes with --to candump and --to pcapng; for states there is --joint");
    if (words.json() && !words.has("--out"))
        return fail(Errc::bad_argument,
                    "--json tells what was written, with --out FILE; sinew replay FILE --json prints "
                    "what is in a recording as JSON");
    auto place = Place::make(words, format == "pcapng");
    if (!place)
        return std::unexpected(place.error());
    record::CandumpWriter candump;
    record::PcapngWriter pcapng;
    std::int64_t rows = 0;
    const auto outcome = format == "csv"       ? write_csv(words, *topic, *place, rows)
                         : format == "candump" ? write_frames(words, candump, *place, rows)
                                               : write_frames(words, pcapng, *place, rows);
    if (!outcome)
        return outcome;
    if (auto kept = place->keep(); !kept)
        return std::unexpected(kept.error());
    if (words.json())
        print(Json::object({{"file", *words.text("--out")}, {"format", format}, {"rows", rows}}));
    return outcome;
}

} // namespace

Verb export_verb()
{
    return {
        .name = "export",
        .says = "Write what is in a recording for other programs: CSV, a candump log or pcapng.",
        .arguments = {recording_argument},
        .options = {{"--to", "FORMAT", "csv (states, commands, events), candump (CAN frames) or pcapng (all frames)"},
                    {"--out", "FILE", "where to; stdout where it is not given"},
                    {"--of", "WHAT", "csv: states (where it is not given), commands or events"},
                    joint_option,
                    {"--bus", "NAME", "frames of this bus only; may be given more than once", true},
                    {"--json", "", "with --out: print what was written"}},
        .examples = {{"sinew export run.mcap --to csv --out run.csv", "for a spreadsheet"},
                     {"sinew export run.mcap --to csv --of commands --joint elbow", "what one joint was told"},
                     {"sinew export run.mcap --to pcapng --out run.pcapng", "for Wireshark"},
                     {"sinew export run.mcap --to candump --bus legs", "for canplayer"}},
        .run = run,
        .more = "Units stand in the names of the columns; time_s is seconds since 1970 (UTC), of simulated buses "
                "since power-on. A value stands in the row in which it was new.",
        .ends = {exit_refused, exit_interrupted}};
}

} // namespace sinew::cli
