#include "apps/cli/exit_codes.hpp"
#include "apps/cli/joint.hpp"
#include "apps/cli/plot.hpp"
#include "apps/cli/recorded_robot.hpp"
#include "apps/cli/step_response.hpp"
#include "apps/cli/verb.hpp"
#include "sinew/base/bytes.hpp"
#include "sinew/base/units.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr const char* demo = "robots/demo.toml";
constexpr Duration default_length = std::chrono::seconds(2);
constexpr Duration shortest = std::chrono::milliseconds(10);
constexpr Duration longest = std::chrono::minutes(10);
constexpr double no_step_rad = 1e-4;    // a load moves it by less before it is held
constexpr std::int64_t gain_most = 254; // of a SAM

std::expected<config::RobotFile, Error> robot(const Words& words)
{
    if (const auto given = words.text("ROBOT"))
        return robot_file_at(*given);
    if (std::filesystem::exists(demo))
        return config::read_robot_file(demo);
    return fail(Errc::bad_argument, fmt::format("which robot? Name its file, such as sinew sim step {}", demo));
}

/// P, I and D as they stand in `--gains 100,0,100`.
std::expected<std::array<std::uint8_t, 3>, Error> gains_from(std::string_view word)
{
    std::array<std::uint8_t, 3> gains{};
    std::string_view left = word;
    for (std::size_t i = 0; i < gains.size(); ++i) {
        const auto comma = std::min(left.find(','), left.size());
        const auto value = to_integer(left.substr(0, comma));
        const bool ends_well = (comma == left.size()) == (i + 1 == gains.size());
        if (!value || *value < 0 || *value > gain_most || !ends_well)
            return fail(Errc::bad_argument,
                        fmt::format("--gains takes P,I,D, three whole numbers from 0 to {} such as 100,0,100, not '{}'",
                                    gain_most, word));
        gains[i] = static_cast<std::uint8_t>(*value);
        left.remove_prefix(std::min(comma + 1, left.size()));
    }
    return gains;
}

std::expected<StepRequest, Error> request_from(const Words& words)
{
    const auto joint = words.text("--joint");
    const auto to_word = words.text("--to");
    if (!joint || !to_word)
        return fail(Errc::bad_argument, fmt::format("{} is missing, such as --joint elbow --to 90deg",
                                                    joint ? "--to ANGLE" : "--joint NAME"));
    const auto to = angle_from(*to_word);
    if (!to)
        return std::unexpected(to.error());
    StepRequest request{.joint = *joint, .to_rad = *to};
    if (const auto word = words.text("--from")) {
        const auto from = angle_from(*word);
        if (!from)
            return std::unexpected(from.error());
        request.from_rad = *from;
    }
    const auto length = words.duration("--for");
    if (!length)
        return std::unexpected(length.error());
    request.length = length->value_or(default_length);
    if (request.length < shortest || request.length > longest)
        return fail(Errc::bad_argument,
                    fmt::format("--for takes a time from {:g} ms to {:g} min, not '{}'", seconds(shortest) * 1e3,
                                seconds(longest) / 60.0, words.text("--for").value_or("")));
    if (const auto word = words.text("--gains")) {
        const auto gains = gains_from(*word);
        if (!gains)
            return std::unexpected(gains.error());
        request.gains = *gains;
    }
    return request;
}

std::string csv(const std::vector<StepSample>& samples)
{
    std::string out = "time_s,position_rad,velocity_rad_s,current_a\n";
    for (const auto& s : samples)
        out += fmt::format("{:.3f},{:.9g},{:.9g},{:.9g}\n", s.time_s, s.position_rad, s.velocity_rad_s, s.current_a);
    return out;
}

Plot plot_of(const StepRequest& request, const std::vector<StepSample>& samples)
{
    Plot plot{.title = fmt::format("{} to {:g}°", request.joint, units::deg(request.to_rad)),
              .x_label = "time in s",
              .panels = {{.label = "position in °", .level = units::deg(request.to_rad), .level_name = "target"},
                         {.label = "velocity in °/s"},
                         {.label = "winding current in A"}}};
    if (const auto& gains = request.gains)
        plot.title += fmt::format(", P {}, I {}, D {}", (*gains)[0], (*gains)[1], (*gains)[2]);
    for (const auto& s : samples) {
        plot.x.push_back(s.time_s);
        plot.panels[0].y.push_back(units::deg(s.position_rad));
        plot.panels[1].y.push_back(units::deg(s.velocity_rad_s));
        plot.panels[2].y.push_back(s.current_a);
    }
    return plot;
}

/// All files that were asked for, or none.
std::expected<void, Error> write_files(const Words& words, const StepRequest& request,
                                       const std::vector<StepSample>& samples)
{
    std::vector<NewFile> files;
    for (const auto* option : {"--csv", "--plot"}) {
        const auto path = words.text(option);
        if (!path)
            continue;
        auto file = NewFile::make(*path);
        if (!file)
            return std::unexpected(file.error());
        auto written = option == std::string_view("--csv") ? file->write(csv(samples))
                                                           : write_plot(*file, plot_of(request, samples));
        if (!written)
            return written;
        files.push_back(std::move(*file));
    }
    for (auto& file : files)
        if (auto kept = file.keep(); !kept)
            return kept;
    return {};
}

void show(const Words& words, const StepRequest& request, double from_rad, const StepFigures& figures)
{
    const auto& gains = request.gains;
    if (words.json()) {
        print(Json::object(
            {{"joint", request.joint},
             {"from_rad", from_rad},
             {"to_rad", request.to_rad},
             {"gains", gains ? Json::object({{"p", (*gains)[0]}, {"i", (*gains)[1]}, {"d", (*gains)[2]}}) : Json()},
             {"rise_time_s", figures.rise_time_s},
             {"overshoot_percent", 100.0 * figures.overshoot},
             {"settling_time_s", figures.settling_time_s},
             {"steady_error_rad", figures.steady_error_rad},
             {"peak_current_a", figures.peak_current_a}}));
        return;
    }
    const auto time = [](const std::optional<double>& time_s) {
        return time_s ? fmt::format("{:.3f} s", *time_s) : std::string("never");
    };
    const double error_deg = units::deg(figures.steady_error_rad);
    fmt::print("rise time      {:<10}  from 10 % to 90 % of the step\n", time(figures.rise_time_s));
    fmt::print("overshoot      {:<10}  of the step\n", fmt::format("{:.1f} %", 100.0 * figures.overshoot));
    fmt::print("settling time  {:<10}  within 2 % of the step\n", time(figures.settling_time_s));
    fmt::print("steady error   {:<10}  target minus position at the end\n",
               fmt::format("{:.2f} deg", std::abs(error_deg) < 0.005 ? 0.0 : error_deg));
    fmt::print("peak current   {:<10}  of the winding\n", fmt::format("{:.2f} A", figures.peak_current_a));
}

Outcome run(const Words& words)
{
    const auto request = request_from(words);
    if (!request)
        return std::unexpected(request.error());
    if (const auto path = words.text("--plot"))
        if (auto fine = check_picture(*path); !fine)
            return std::unexpected(fine.error());
    auto file = robot(words);
    if (!file)
        return std::unexpected(file.error());
    const auto samples = step_response(std::move(*file), *request);
    if (!samples)
        return std::unexpected(samples.error());
    const double from_rad = samples->front().position_rad;
    if (std::abs(request->to_rad - from_rad) < no_step_rad)
        return fail(Errc::bad_argument, fmt::format("{} stands at {:g} deg already; give another --to or --from",
                                                    request->joint, units::deg(request->to_rad)));
    if (auto written = write_files(words, *request, *samples); !written)
        return std::unexpected(written.error());
    show(words, *request, from_rad, figures_of(*samples, request->to_rad));
    return exit_done;
}

} // namespace

Verb sim_step_verb()
{
    return {.name = "sim step",
            .says = "Send a simulated joint somewhere at once and say how well it gets there.",
            .arguments = {{"ROBOT", "its robot file; robots/demo.toml where that exists", false}},
            .options = {{"--joint", "NAME", "the joint"},
                        {"--to", "ANGLE", "where it is sent, such as 90deg, 1.57rad or 0.25turn"},
                        {"--from", "ANGLE", "where it stands before; otherwise as the robot file has it"},
                        {"--for", "TIME", "how long it is looked at; 2s where it is not given"},
                        {"--gains", "P,I,D", "gains of the position loop, of a SAM only"},
                        {"--plot", "FILE", "draw position, velocity and current into this SVG file (by gnuplot)"},
                        {"--csv", "FILE", "write a line per millisecond into this file"},
                        {"--json", "", "print the figures as JSON"}},
            .examples = {{"sinew sim step --joint elbow --to 60deg --plot step.svg", "a picture"},
                         {"sinew sim step arm.toml --joint elbow --to 60deg --gains 100,0,50 --json", "for tuning"}},
            .run = run,
            .more = "It runs in virtual time and needs no `sinew sim`. What the joint carries stands in the robot file "
                    "under [joint.NAME.plant].",
            .ends = {exit_no_answer, exit_refused}};
}

} // namespace sinew::cli
