#pragma once
#include "sinew/base/error.hpp"

#include <span>
#include <string_view>
#include <vector>

namespace sinew::cli {

/// What the command leaves behind for scripts. The numbers stay.
struct ExitCode {
    int number = 0;
    std::string_view says;
    std::vector<Errc> of; ///< the errors that end with it
};

inline constexpr int exit_done = 0;
inline constexpr int exit_internal = 1;
inline constexpr int exit_usage = 2;
inline constexpr int exit_no_answer = 7;
inline constexpr int exit_bad_answer = 8;
inline constexpr int exit_refused = 10;
inline constexpr int exit_diagnosed_warning = 11;
inline constexpr int exit_diagnosed_error = 12;
inline constexpr int exit_differs = 13;
inline constexpr int exit_at_limit = 14;
inline constexpr int exit_interrupted = 130;

std::span<const ExitCode> exit_codes();
int exit_code(Errc code);

} // namespace sinew::cli
