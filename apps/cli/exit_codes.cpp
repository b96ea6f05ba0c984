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
        {3, "the link is not there", {link_not_found}},
        {4, "the link is in use by another program", {link_busy}},
        {5, "not permitted to use the link", {link_denied}},
        {6, "the link was lost or failed", {link_lost, link_failed}},
        {exit_no_answer, "no device answered, or a joint did not get where it was sent", {timeout}},
        {exit_bad_answer,
         "bytes or an answer that are wrong",
         {bad_length, bad_constant, bad_checksum, bad_repeat, bad_reply}},
        {9, "a file that cannot be used, or can take no more (a full disk)", {bad_file}},
        {exit_refused, "refused: the device or its firmware line cannot do it", {not_in_profile, unsupported}},
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

} // namespace sinew::cli
