#include "apps/cli/chart.hpp"
#include "apps/cli/device.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/plot.hpp"
#include "apps/cli/recording.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sinew::cli {
namespace {

using record::Topic;

/// One value of one joint over time.
struct Curve {
    std::string joint;
    std::string value;
    std::vector<double> time_s; ///< since the first message
    std::vector<double> y;

    std::string name() const { return fmt::format("{} {}", joint, value); }
};

std::expected<std::vector<std::string>, Error> values_from(const Words& words)
{
    std::vector<std::string_view> names;
    for (const auto& column : record::columns_of(Topic::state))
        if (column.type == "number")
            names.push_back(column.name);
    std::vector<std::string> out;
    for (const auto& word : words.all("--value")) {
        if (std::ranges::find(names, word) == names.end())
            return fail(Errc::unknown_name, fmt::format("there is no value '{}'{}; there are {}", word,
                                                        did_you_mean(word, names), fmt::join(names, ", ")));
        out.push_back(word);
    }
    if (out.empty())
        out.emplace_back(names.front());
    return out;
}

/// The curves in the order of joints and values.
Outcome read_curves(const Words& words, const std::vector<std::string>& values, std::vector<Curve>& out)
{
    const auto joints = words.all("--joint");
    std::optional<record::Time> first;
    std::map<std::pair<std::string, std::string>, std::size_t> known;
    std::set<std::string> seen;
    const auto outcome = read_recording(*words.text("FILE"), [&](const Recorded& one) {
        first = first.value_or(one.at);
        if (one.topic != Topic::state)
            return true;
        seen.insert(one.name);
        if (!joints.empty() && std::ranges::find(joints, one.name) == joints.end())
            return true;
        for (const auto& value : values)
            if (const auto number = one.fields.number(value)) {
                const auto [place, is_new] = known.try_emplace({one.name, value}, out.size());
                if (is_new)
                    out.push_back({.joint = one.name, .value = value});
                out[place->second].time_s.push_back(seconds(one.at - *first));
                out[place->second].y.push_back(*number);
            }
        return true;
    });
    if (!outcome)
        return outcome;
    if (auto there = check_names("joint", *words.text("FILE"), joints, seen); !there)
        return std::unexpected(there.error());
    if (out.empty())
        return fail(Errc::bad_file, fmt::format("{} has no {}", *words.text("FILE"), fmt::join(values, " or ")));
    return outcome;
}

std::expected<void, Error> draw(const std::string& from, const std::string& to, std::vector<Curve> curves)
{
    std::error_code none;
    if (std::filesystem::equivalent(from, to, none))
        return fail(Errc::bad_argument, "a recording cannot be written over by its own picture; give another --out");
    auto file = NewFile::make(to);
    if (!file)
        return std::unexpected(file.error());
    Plot plot{.title = from, .x_label = "time in s", .x = {0.0, 0.0}, .panels = {}};
    for (auto& curve : curves) {
        plot.x[1] = std::max(plot.x[1], curve.time_s.back());
        plot.panels.push_back({.label = curve.name(), .y = std::move(curve.y), .x = std::move(curve.time_s)});
    }
    if (auto written = write_plot(*file, plot); !written)
        return written;
    return file->keep();
}

void print_charts(const std::vector<Curve>& curves)
{
    constexpr std::size_t height = 4, margin = 12, most = 120;
    const std::size_t width = std::clamp<std::size_t>(columns(), 40, most) - margin;
    for (const auto& curve : curves) {
        const auto [low, high] = std::ranges::minmax(curve.y);
        fmt::print("{}\n", bold(curve.name()));
        const auto lines = chart(curve.time_s, curve.y, width, height);
        for (std::size_t i = 0; i < lines.size(); ++i)
            fmt::print("{:>10} {}\n",
                       i == 0            ? fmt::format("{:.4g}", high)
                       : i + 1 == height ? fmt::format("{:.4g}", low)
                                         : "",
                       lines[i]);
        const auto begin = fmt::format("{:.3f} s", curve.time_s.front()),
                   end = fmt::format("{:.3f} s", curve.time_s.back());
        fmt::print("{:>10} {}{:>{}}\n", "", begin, end, width - begin.size());
    }
}

void print_json(const std::vector<Curve>& curves)
{
    Json out = Json::array();
    for (const auto& curve : curves) {
        const auto [low, high] = std::ranges::minmax(curve.y);
        out.add(Json::object({{"joint", curve.joint},
                              {"value", curve.value},
                              {"count", static_cast<std::int64_t>(curve.y.size())},
                              {"low", low},
                              {"high", high},
                              {"first", curve.y.front()},
                              {"last", curve.y.back()},
                              {"begin_s", curve.time_s.front()},
                              {"end_s", curve.time_s.back()}}));
    }
    print(out);
}

Outcome run(const Words& words)
{
    const auto values = values_from(words);
    if (!values)
        return std::unexpected(values.error());
    if (const auto to = words.text("--out"))
        if (auto fine = check_picture(*to); !fine)
            return std::unexpected(fine.error());
    std::vector<Curve> curves;
    const auto outcome = read_curves(words, *values, curves);
    if (!outcome)
        return outcome;
    if (words.json())
        print_json(curves);
    else if (!words.has("--out"))
        print_charts(curves);
    if (const auto to = words.text("--out")) {
        if (auto drawn = draw(*words.text("FILE"), *to, std::move(curves)); !drawn)
            return std::unexpected(drawn.error());
    }
    return outcome;
}

} // namespace

Verb plot_verb()
{
    return {
        .name = "plot",
        .says = "Draw what joints did: on the terminal, or as an SVG picture.",
        .arguments = {recording_argument},
        .options = {{"--value", "NAME",
                     "position_rad (where it is not given), velocity_rad_s, current_a, voltage_v, temperature_c; may "
                     "be given more than once",
                     true},
                    joint_option,
                    {"--out", "FILE.svg", "a picture, drawn by gnuplot"},
                    {"--json", "", "print a list with the range of every curve"}},
        .examples = {{"sinew plot run.mcap", "the positions of all joints"},
                     {"sinew plot run.mcap --joint elbow --value position_rad --value current_a --out elbow.svg",
                      "two values of one joint"}},
        .run = run,
        .ends = {exit_refused}};
}

} // namespace sinew::cli
