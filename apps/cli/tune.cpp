#include "apps/cli/confirm.hpp"
#include "apps/cli/exit_codes.hpp"
#include "apps/cli/gains.hpp"
#include "apps/cli/measured_step.hpp"
#include "apps/cli/moving.hpp"
#include "apps/cli/plot.hpp"
#include "apps/cli/robot_record.hpp"
#include "apps/cli/terminal.hpp"
#include "sinew/base/units.hpp"
#include "sinew/robot/rules.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

constexpr Duration default_length = std::chrono::seconds(2);
constexpr double no_step_rad = units::rad(0.5);

struct Trial {
    double to_rad = 0.0;
    Duration length = default_length;
    std::vector<std::string> gains; ///< "p=30"
};

std::expected<Trial, Error> trial_from(const Words& words)
{
    Trial trial;
    const auto to = words.text("--to");
    if (!to)
        return fail(Errc::bad_argument, "--to ANGLE is missing: where the step goes, such as --to 20deg");
    const auto angle = angle_from(*to);
    if (!angle)
        return std::unexpected(angle.error());
    trial.to_rad = *angle;
    const auto length = words.duration("--for");
    if (!length)
        return std::unexpected(length.error());
    trial.length = length->value_or(default_length);
    if (const auto path = words.text("--plot"))
        if (auto fine = check_picture(*path); !fine)
            return std::unexpected(fine.error());
    for (const auto& word : words.all("--gain"))
        trial.gains.push_back(word);
    if (words.has("--keep") && trial.gains.empty())
        return fail(Errc::bad_argument, "--keep stores the gains that --gain tries; give them as well");
    return trial;
}

Plot plot_of(const Device& device, const Trial& trial, const std::vector<StepSample>& samples)
{
    Plot plot{.title = fmt::format("{} to {:g}°", device.name, units::deg(trial.to_rad)),
              .x_label = "time in s",
              .panels = {{.label = "position in °", .level = units::deg(trial.to_rad), .level_name = "target"},
                         {.label = "velocity in °/s"}}};
    for (const auto& gain : trial.gains)
        plot.title += ", " + gain;
    for (const auto& sample : samples) {
        plot.x.push_back(sample.time_s);
        plot.panels[0].y.push_back(units::deg(sample.position_rad));
        plot.panels[1].y.push_back(units::deg(sample.velocity_rad_s));
    }
    return plot;
}

/// What became of the gains that were tried.
enum class Kept { no, yes };

void show(const Words& words, const Device& device, const Trial& trial, const std::vector<StepSample>& samples,
          Kept kept)
{
    const auto figures = figures_of(samples, trial.to_rad);
    if (words.json()) {
        Json gains = Json::array();
        for (const auto& gain : trial.gains)
            gains.add(gain);
        print(Json::object({{"device", device.name},
                            {"from_rad", samples.front().position_rad},
                            {"to_rad", trial.to_rad},
                            {"gains", std::move(gains)},
                            {"kept", kept == Kept::yes},
                            {"samples", static_cast<std::int64_t>(samples.size())},
                            {"rise_time_s", figures.rise_time_s},
                            {"overshoot_percent", 100.0 * figures.overshoot},
                            {"settling_time_s", figures.settling_time_s},
                            {"steady_error_rad", figures.steady_error_rad}}));
        return;
    }
    const auto plot = plot_of(device, trial, samples);
    fmt::print("{}\n", text_plot(plot.x, plot.panels[0], columns(), 12));
    const auto time = [](const std::optional<double>& time_s) {
        return time_s ? fmt::format("{:.3f} s", *time_s) : std::string("never");
    };
    fmt::print("rise time      {:<10}  from 10 % to 90 % of the step\n", time(figures.rise_time_s));
    fmt::print("overshoot      {:<10}  of the step\n", fmt::format("{:.1f} %", 100.0 * figures.overshoot));
    fmt::print("settling time  {:<10}  within 2 % of the step\n", time(figures.settling_time_s));
    fmt::print("steady error   {:<10}  target minus position at the end\n",
               fmt::format("{:.2f} deg", units::deg(figures.steady_error_rad)));
    fmt::print("looks          {:<10}  {:.0f} a second\n", samples.size(),
               static_cast<double>(samples.size()) / seconds(trial.length));
}

std::expected<void, Error> draw(const Words& words, const Device& device, const Trial& trial,
                                const std::vector<StepSample>& samples)
{
    const auto path = words.text("--plot");
    if (!path)
        return {};
    auto file = NewFile::make(*path);
    if (!file)
        return std::unexpected(file.error());
    if (auto drawn = write_plot(*file, plot_of(device, trial, samples)); !drawn)
        return drawn;
    return file->keep();
}

/// What is left of the step is what a load or soft gains leave: the motor may stay on its way, for it will not leap.
bool has_gone(const std::vector<StepSample>& samples, double to_rad)
{
    const double left_rad = std::abs(to_rad - samples.back().position_rad);
    return left_rad <= robot::giving_way_rad && left_rad <= std::abs(to_rad - samples.front().position_rad) / 2.0;
}

/// The step with the gains that are set now. What was measured stays in `samples` also where it did not get there.
Outcome step(const Words& words, Session& session, Driven& driven, const Trial& trial, std::vector<StepSample>& samples)
{
    Supervised supervised(session, driven, Reached::by_a_leap);
    auto measured = measured_step(session, driven, supervised, trial.to_rad, trial.length);
    if (interrupted())
        return stop_here(session, driven);
    if (!measured && !supervised.has_sent())
        return std::unexpected(measured.error());
    if (!measured)
        return stopped_for(session, driven, measured.error());
    samples = std::move(*measured);
    Outcome outcome = exit_done;
    if (!has_gone(samples, trial.to_rad))
        outcome = held_after(session, driven,
                             {.code = Errc::timeout,
                              .detail = fmt::format("{} is at {:.2f} deg after {:g} s, short of {:.2f} deg; is "
                                                    "something in its way, or does it need more --for?",
                                                    driven.device.name, units::deg(samples.back().position_rad),
                                                    seconds(trial.length), units::deg(trial.to_rad))});
    if (auto drawn = draw(words, driven.device, trial, samples); outcome && !drawn)
        return std::unexpected(drawn.error());
    return outcome;
}

Outcome as_it_is(const Words& words, Session& session, Driven& driven, const Trial& trial)
{
    std::vector<StepSample> samples;
    const auto outcome = step(words, session, driven, trial, samples);
    if (!samples.empty())
        show(words, driven.device, trial, samples, Kept::no);
    return outcome;
}

/// A signal does not cut it short, and what is not acknowledged is sent again.
std::expected<void, Error> set_back(const Gains& gains, const Driven& driven)
{
    const Undisturbed undisturbed;
    const auto back = until_confirmed([&] { return gains.set_back(*driven.bus, driven.device); });
    if (!back)
        return fail(back.error().code, fmt::format("{} may still have the gains that were tried, until power-off: {}",
                                                   driven.device.name, to_sentence(back.error())));
    return {};
}

Outcome with_gains(const Words& words, Session& session, Driven& driven, const Trial& trial)
{
    auto gains = Gains::from(*driven.bus, driven.device, trial.gains);
    if (!gains)
        return std::unexpected(gains.error());
    const auto back_after = [&](const Error& what) {
        const auto back = set_back(*gains, driven);
        return fail(what.code, fmt::format("{}; {}", to_sentence(what),
                                           back ? "the gains that were there before are in use again"
                                                : to_sentence(back.error())));
    };
    if (auto set = gains->set_trial(*driven.bus, driven.device); !set)
        return back_after(set.error());
    std::vector<StepSample> samples;
    const auto outcome = step(words, session, driven, trial, samples);
    if (outcome && *outcome == exit_done && words.has("--keep")) {
        const auto stored = gains->store(*driven.bus, driven.device);
        // What was measured is true whether they could be kept or not.
        show(words, driven.device, trial, samples, stored ? Kept::yes : Kept::no);
        if (!stored)
            return back_after(stored.error());
        fmt::print(stderr, "The gains are kept in flash.\n");
        return outcome;
    }
    if (auto back = set_back(*gains, driven); !back)
        return std::unexpected(back.error());
    if (!samples.empty())
        show(words, driven.device, trial, samples, Kept::no);
    return outcome;
}

Outcome run(const Words& words)
{
    const auto trial = trial_from(words);
    if (!trial)
        return std::unexpected(trial.error());
    auto device = target(words);
    if (!device)
        return std::unexpected(device.error());
    if (auto fine = check_limits(*device, trial->to_rad, std::nullopt); !fine)
        return std::unexpected(fine.error());
    if (!trial->gains.empty())
        if (auto fine = Gains::check(*device, trial->gains); !fine)
            return std::unexpected(fine.error());
    const auto yes = confirm(words, fmt::format("{} will leap to {:g} deg{}", device->name, units::deg(trial->to_rad),
                                                words.has("--keep") ? ", and its gains are written to flash" : ""));
    if (!yes)
        return std::unexpected(yes.error());
    if (!*yes)
        return exit_refused;
    const auto record = DeviceRecord::make(words);
    if (!record)
        return std::unexpected(record.error());
    Session session;
    auto driven = drive_and_read(session, std::move(*device));
    if (!driven)
        return std::unexpected(driven.error());
    const auto from = start_of(*driven);
    if (!from)
        return std::unexpected(from.error());
    if (std::abs(*from - trial->to_rad) < no_step_rad)
        return fail(Errc::bad_argument,
                    fmt::format("{} stands at {} already; give another --to", driven->device.name, place_of(*driven)));
    if (*record)
        (*record)->watch(session, *driven);
    return recorded(trial->gains.empty() ? as_it_is(words, session, *driven, *trial)
                                         : with_gains(words, session, *driven, *trial),
                    record->get());
}

} // namespace

Verb tune_verb()
{
    return {.name = "tune",
            .says = "Send a device somewhere at once, show how well it gets there, and try gains.",
            .arguments = {target_argument},
            .options = with_device_options(
                {{"--to", "ANGLE", "where the step goes, such as 20deg"},
                 {"--gain", "NAME=N", "a gain to try: p, i or d as a raw number; may be given more than once", true},
                 {"--keep", "", "store the gains of --gain in flash afterwards"},
                 {"--for", "TIME", "how long it is looked at; 2s where it is not given"},
                 {"--plot", "FILE", "draw position and velocity into this SVG file (by gnuplot)"},
                 record_option,
                 yes_option,
                 json_option}),
            .examples = {{"sinew tune elbow --to 20deg --robot arm.toml", "as it is; asks first"},
                         {"sinew tune elbow --to 20deg --gain p=120 --gain d=60 --robot arm.toml --sim --yes",
                          "try gains, simulated"},
                         {"sinew tune elbow --to 20deg --robot arm.toml --sim --yes --record step.mcap",
                          "for sinew plot and sinew export"},
                         {"sinew tune left_knee --to 20deg --gain p=80 --keep --robot arm.toml", "and keep them"}},
            .run = run,
            .acts = true,
            .more = "Gains are set until power-off, and what was there before is set back afterwards; --keep stores "
                    "them instead. A Nuri has no gains to try: sinew set TARGET position-controller stores them. The "
                    "joint stays where the step went; one that does not get there is held where it is then. "
                    "step_max_deg of the robot file says how long a step may be, and "
                    "its other limits hold for what is measured. Looks are as many as the bus allows: steps that are "
                    "faster than "
                    "that are not seen well.",
            .ends = {exit_at_limit}};
}

} // namespace sinew::cli
