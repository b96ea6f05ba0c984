#pragma once
#include "apps/cli/joint.hpp"

#include <span>

/// What `watch` shows on a terminal.
namespace sinew::cli {

/// One device of the table, with what went wrong with it last.
struct Watched {
    Driven driven;
    std::string trouble;
    bool lost = false;           ///< it is the link that is in trouble
    std::vector<double> trend{}; ///< positions of the last looks
};

inline constexpr std::size_t longest_trend = 24;

/// "no answer" or "link lost".
std::string_view no_state(const Watched& watched);

/// The joints that the screen has room for, as many columns of each as fit, and a line for each bus; over the picture
/// before, which had `above` lines.
void print_picture(const Session& session, std::span<const Watched> all, std::ptrdiff_t& above);

} // namespace sinew::cli
