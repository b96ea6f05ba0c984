#pragma once
#include "apps/cli/verb.hpp"
#include "sinew/base/error.hpp"

#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew::cli {

/// What the command leaves behind for scripts. The numbers stay.
struct ExitCode {
    int number = 0;
    std::string_view says;
    std::vector<Errc> of;         ///< the errors that end with it
    std::string_view of_motion{}; ///< what it says of a verb that moves something; empty: the same
};

inline constexpr int exit_done = 0;
inline constexpr int exit_internal = 1;
inline constexpr int exit_usage = 2;
inline constexpr int exit_no_link = 3;
inline constexpr int exit_link_lost = 6;
inline constexpr int exit_no_answer = 7;
inline constexpr int exit_bad_answer = 8;
inline constexpr int exit_bad_file = 9;
inline constexpr int exit_refused = 10;
inline constexpr int exit_diagnosed_warning = 11;
inline constexpr int exit_diagnosed_error = 12;
inline constexpr int exit_differs = 13;
inline constexpr int exit_at_limit = 14;
inline constexpr int exit_interrupted = 130;

std::span<const ExitCode> exit_codes();

/// Those that a verb can end with, and what each says of it: by what its words name (devices, files, a simulator), and
/// by its row.
std::vector<std::pair<int, std::string_view>> exit_codes_of(const Verb& verb);
int exit_code(Errc code);

} // namespace sinew::cli
