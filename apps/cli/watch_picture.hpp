#pragma once
#include "apps/cli/joint.hpp"
#include "apps/cli/link_report.hpp"

#include <cstdio>
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

/// As the robot file calls it.
std::string name_of(const bus::Bus& bus, std::span<const Watched> all);

/// Of a terminal; large where it does not say.
struct Window {
    std::size_t columns = 80, rows = 1000;
};
Window window_of(int fd);

/// A text in the place of the one before, which had `above` lines.
void print_over(std::FILE* out, std::string_view text, std::ptrdiff_t& above);

/// The joints that the screen has room for, as many columns of each as fit, a line for each bus and one for what its
/// link tells of troubles; over the picture before, which had `above` lines.
void print_picture(const Session& session, const LinkReports& reports, std::span<const Watched> all,
                   std::ptrdiff_t& above);

} // namespace sinew::cli
