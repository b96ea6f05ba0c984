#pragma once
#include "apps/cli/new_file.hpp"

#include <optional>
#include <string>
#include <vector>

/// Pictures for people, drawn by gnuplot.
namespace sinew::cli {

/// One curve over the common axis.
struct Panel {
    std::string label; ///< with the unit
    std::vector<double> y;
    std::optional<double> level{}; ///< a thin line across, such as a target
    std::string level_name{};
    std::vector<double> x{}; ///< its own, as many as `y`; empty: that of the plot
};

/// Panels above each other that share their horizontal axis.
struct Plot {
    std::string title;
    std::string x_label;       ///< with the unit
    std::vector<double> x;     ///< its first and last value are the ends of the axis
    std::vector<Panel> panels; ///< as many values each as `x`
};

/// A panel in characters for a terminal, `width` columns and `height` lines of it beside its scale; the level is a line
/// of dots.
std::string text_plot(const std::vector<double>& x, const Panel& panel, std::size_t width, std::size_t height);

/// The last values as one line of blocks, `width` columns at most, from the lowest to the highest of them.
std::string sparkline(const std::vector<double>& values, std::size_t width);

/// What gnuplot is told to do.
std::string gnuplot_script(const Plot& plot);

/// `bad_argument` for a name that promises another kind of picture than SVG.
std::expected<void, Error> check_picture(const std::string& path);

/// The plot as SVG into `file`, which is not kept yet. `unsupported` where there is no gnuplot, with the package that
/// has it; `bad_argument` with gnuplot's words where it fails.
std::expected<void, Error> write_plot(NewFile& file, const Plot& plot);

} // namespace sinew::cli
