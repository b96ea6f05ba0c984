#include "apps/cli/verb.hpp"

#include "sinew/base/bytes.hpp"
#include "sinew/base/seconds.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {

std::span<const std::string> Words::all(std::string_view name) const
{
    const auto found = all_.find(name);
    return found == all_.end() ? std::span<const std::string>{} : std::span(found->second);
}

std::optional<std::string> Words::text(std::string_view name) const
{
    const auto words = all(name);
    return words.empty() ? std::nullopt : std::optional(words.back());
}

std::expected<std::optional<std::int64_t>, Error> Words::number(std::string_view name, std::int64_t low,
                                                                std::int64_t high) const
{
    const auto word = text(name);
    if (!word)
        return std::nullopt;
    const auto value = to_integer(*word);
    if (!value || *value < low || *value > high)
        return fail(Errc::bad_argument,
                    fmt::format("{} takes a whole number from {} to {}, not '{}'", name, low, high, *word));
    return *value;
}

std::expected<std::optional<Duration>, Error> Words::duration(std::string_view name) const
{
    const auto word = text(name);
    if (!word)
        return std::nullopt;
    return duration_from(name, *word);
}

std::expected<std::optional<Duration>, Error> Words::period(std::string_view name) const
{
    constexpr double highest_hz = 1000.0;
    const auto word = text(name);
    if (!word)
        return std::nullopt;
    double rate = 0.0;
    const auto [end, problem] = std::from_chars(word->data(), word->data() + word->size(), rate);
    const std::string_view unit(end, static_cast<std::size_t>(word->data() + word->size() - end));
    if (problem != std::errc{} || (!unit.empty() && unit != "Hz") || !(rate > 0.0 && rate <= highest_hz))
        return fail(Errc::bad_argument,
                    fmt::format("{} takes looks per second up to {:g}, not '{}'", name, highest_hz, *word));
    return from_seconds(1.0 / rate);
}

std::expected<Duration, Error> duration_from(std::string_view name, std::string_view word)
{
    double value = 0.0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
    const std::string_view unit(end, static_cast<std::size_t>(word.data() + word.size() - end));
    const double scale = unit.empty() || unit == "s" ? 1.0 : unit == "ms" ? 1e-3 : unit == "min" ? 60.0 : 0.0;
    constexpr double longest_s = 1e8;
    if (problem != std::errc{} || scale == 0.0 || !std::isfinite(value) || value <= 0.0 || value * scale > longest_s)
        return fail(Errc::bad_argument,
                    fmt::format("{} takes a time such as 10s, 500ms or 2min, not '{}'", name, word));
    return from_seconds(value * scale);
}

std::span<const Verb> verbs()
{
    static const std::vector<Verb> all{
        sim_verb(),
        sim_step_verb(),
        sim_look_verb(),
        sim_fault_verb(),
        sim_mend_verb(),
        scan_verb(),
        doctor_verb(),
        info_verb(),
        get_verb(),
        set_verb(),
        id_verb(),
        baud_verb(),
        save_verb(),
        diff_verb(),
        restore_verb(),
        zero_verb(),
        home_verb(),
        calibrate_verb(),
        tune_verb(),
        jog_verb(),
        move_verb(),
        play_verb(),
        teach_verb(),
        stop_verb(),
        watch_verb(),
        plan_verb(),
        bus_verb(),
        sniff_verb(),
        record_verb(),
        replay_verb(),
        plot_verb(),
        export_verb(),
        import_verb(),
        recover_verb(),
        send_verb(),
        motion_assemble_verb(),
        motion_show_verb(),
        motion_simulate_verb(),
        motion_upload_verb(),
        decode_verb(),
        messages_verb(),
        dissector_verb(),
        snapshot_verb(),
        completion_verb(),
        man_verb(),
    };
    return all;
}

} // namespace sinew::cli
