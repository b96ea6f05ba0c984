#include "apps/cli/exit_codes.hpp"

#include <algorithm>

namespace sinew::cli {

std::span<const ExitCode> exit_codes()
{
    using enum Errc;
    static const std::vector<ExitCode> all{
        {exit_done, "done", {}},
        {exit_internal, "a bug of sinew, or stdout could not be written", {}},
        {exit_usage,
         "a word, name, number or id that cannot be right; nothing was sent",
         {bad_argument, out_of_range, unknown_name, missing_field, bad_id, bad_hex, bad_uri}},
        {exit_no_link, "the link is not there", {link_not_found}},
        {4, "the link is in use by another program", {link_busy}},
        {5, "not permitted to use the link", {link_denied}},
        {exit_link_lost, "the link was lost or failed", {link_lost, link_failed}},
        {exit_no_answer,
         "no device answered",
         {timeout},
         "no device answered, or a joint did not get where it was sent"},
        {exit_bad_answer,
         "bytes or an answer that are wrong",
         {bad_length, bad_constant, bad_checksum, bad_repeat, bad_reply}},
        {exit_bad_file, "a file that cannot be used, or can take no more (a full disk)", {bad_file}},
        {exit_refused,
         "refused: by who was asked, or the device, its firmware line or this machine cannot do it",
         {not_in_profile, unsupported}},
        {exit_diagnosed_warning, "doctor found warnings, and nothing worse", {}},
        {exit_diagnosed_error, "doctor found errors", {}},
        {exit_differs, "diff found differences", {}},
        {exit_at_limit, "a joint came to a limit of the robot file and was stopped", {}},
        {exit_interrupted, "ended by Ctrl-C", {stopped}},
    };
    return all;
}

int exit_code(Errc code)
{
    for (const auto& row : exit_codes())
        if (std::ranges::find(row.of, code) != row.of.end())
            return row.number;
    return exit_internal;
}

namespace {

bool is_device(std::string_view name)
{
    return name == "LINK" || name == "BUS" || name == "TARGET" || name == "WHAT" || name == "--link" || name == "--sim";
}

bool is_file(std::string_view name)
{
    return name == "WHAT" || name == "LOG" || name == "TEXT" || name.contains("FILE") || name.contains("ROBOT");
}

/// What the words of a verb name.
struct Reach {
    bool devices = false;
    bool files = false;
    bool simulator = false; ///< the one that runs, and nothing else
};

Reach reach_of(const Verb& verb)
{
    Reach out;
    for (const auto& argument : verb.arguments) {
        out.devices = out.devices || is_device(argument.name);
        out.files = out.files || is_file(argument.name);
    }
    for (const auto& option : verb.options) {
        out.devices = out.devices || is_device(option.name);
        out.files = out.files || is_file(option.value);
        out.simulator = out.simulator || option.name == "--pid";
    }
    return out;
}

bool can_end(const Verb& verb, int code)
{
    if (code <= exit_usage || std::ranges::find(verb.ends, code) != verb.ends.end())
        return true;
    const auto reach = reach_of(verb);
    if (reach.simulator)
        return code == exit_no_link || code == exit_link_lost || code == exit_no_answer;
    return (reach.devices && (code <= exit_bad_answer || code == exit_refused || code == exit_interrupted)) ||
           (reach.files && code == exit_bad_file);
}

} // namespace

std::vector<std::pair<int, std::string_view>> exit_codes_of(const Verb& verb)
{
    const bool moves = std::ranges::find(verb.ends, exit_at_limit) != verb.ends.end();
    std::vector<std::pair<int, std::string_view>> out;
    for (const auto& row : exit_codes())
        if (can_end(verb, row.number))
            out.emplace_back(row.number, moves && !row.of_motion.empty() ? row.of_motion : row.says);
    return out;
}

} // namespace sinew::cli
