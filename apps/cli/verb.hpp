#pragma once
#include "sinew/base/error.hpp"

#include <expected>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The command model: every verb is one row. Parser, help and suggestions are made from the rows.
namespace sinew::cli {

struct Argument {
    std::string_view name; ///< "LINK"
    std::string_view says;
    bool required = true;
    bool many = false; ///< takes all words that are left; the last one only
};

struct Option {
    std::string_view name;  ///< "--family"
    std::string_view value; ///< what stands in its place, "F"; empty: a switch
    std::string_view says;
    bool many = false; ///< may be given more than once
};

struct Example {
    std::string_view line;
    std::string_view says;
};

/// What was written after the verb. Names that a verb does not have are our own bug and read as not given.
class Words
{
public:
    void add(std::string_view name, std::string value) { all_[std::string(name)].push_back(std::move(value)); }

    bool has(std::string_view name) const { return !all(name).empty(); }
    /// Nothing if it was not given.
    std::optional<std::string> text(std::string_view name) const;
    std::span<const std::string> all(std::string_view name) const;
    /// A whole number between `low` and `high`, `bad_argument` otherwise; nothing if it was not given.
    std::expected<std::optional<std::int64_t>, Error> number(std::string_view name, std::int64_t low,
                                                             std::int64_t high) const;
    /// A positive number of seconds: `10s`, `500ms`, `2min` or plain `10`.
    std::expected<std::optional<Duration>, Error> duration(std::string_view name) const;

    /// The time between two of so many per second: `100`, `100Hz`.
    std::expected<std::optional<Duration>, Error> period(std::string_view name) const;

    bool json() const { return has("--json"); }

    /// They are for a verb that acts on devices: a recording of some will not do.
    bool act = false;

private:
    std::map<std::string, std::vector<std::string>, std::less<>> all_;
};

/// A positive number of seconds, as `Words::duration` reads it; `name` is who takes it.
std::expected<Duration, Error> duration_from(std::string_view name, std::string_view word);

/// The exit code, or what went wrong, of which `main` makes a sentence and the exit code that belongs to it.
using Outcome = std::expected<int, Error>;

struct Verb {
    std::string_view name;
    std::string_view says; ///< one sentence
    std::vector<Argument> arguments;
    std::vector<Option> options;
    std::vector<Example> examples;
    Outcome (*run)(const Words&) = nullptr;
    bool acts = false;       ///< it moves or stops something, or sets or writes it
    std::string_view more{}; ///< what else must be known, after the options
    std::vector<int> ends{}; ///< exit codes beside those that its words bring with them (`exit_codes_of`)
};

/// Every verb, in the order of the help.
std::span<const Verb> verbs();

// One row per file.
Verb sim_verb();
Verb sim_step_verb();
Verb sim_look_verb();
Verb sim_fault_verb();
Verb sim_mend_verb();
Verb scan_verb();
Verb doctor_verb();
Verb info_verb();
Verb get_verb();
Verb set_verb();
Verb id_verb();
Verb baud_verb();
Verb save_verb();
Verb diff_verb();
Verb restore_verb();
Verb zero_verb();
Verb home_verb();
Verb calibrate_verb();
Verb tune_verb();
Verb jog_verb();
Verb motion_assemble_verb();
Verb motion_show_verb();
Verb motion_simulate_verb();
Verb motion_upload_verb();
Verb snapshot_verb();
Verb completion_verb();
Verb man_verb();
Verb move_verb();
Verb play_verb();
Verb teach_verb();
Verb stop_verb();
Verb watch_verb();
Verb plan_verb();
Verb bus_verb();
Verb sniff_verb();
Verb record_verb();
Verb replay_verb();
Verb plot_verb();
Verb export_verb();
Verb import_verb();
Verb recover_verb();
Verb send_verb();
Verb decode_verb();
Verb messages_verb();
Verb dissector_verb();

} // namespace sinew::cli
