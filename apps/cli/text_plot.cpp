#include "apps/cli/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

struct Scale {
    double low = 0.0, high = 1.0;

    std::size_t row(double value, std::size_t height) const
    {
        const double share = (high - value) / (high - low);
        return static_cast<std::size_t>(
            std::clamp(std::lround(share * static_cast<double>(height - 1)), 0L, static_cast<long>(height - 1)));
    }
};

Scale scale_of(const Panel& panel)
{
    Scale out{.low = panel.level.value_or(panel.y.front()), .high = panel.level.value_or(panel.y.front())};
    for (const double value : panel.y) {
        out.low = std::min(out.low, value);
        out.high = std::max(out.high, value);
    }
    if (out.high - out.low < 1e-9)
        out.high = out.low + 1.0;
    return out;
}

} // namespace

std::string text_plot(const std::vector<double>& x, const Panel& panel, std::size_t width, std::size_t height)
{
    if (x.empty() || panel.y.size() != x.size() || height < 2)
        return {};
    constexpr std::size_t margin = 10;
    const std::size_t across = std::max<std::size_t>(width, margin + 12) - margin - 1;
    const Scale scale = scale_of(panel);
    std::vector<std::string> rows(height, std::string(across, ' '));
    if (panel.level)
        rows[scale.row(*panel.level, height)] = std::string(across, '.');
    const double span = std::max(x.back() - x.front(), 1e-9);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double share = (x[i] - x.front()) / span;
        const auto column = static_cast<std::size_t>(std::lround(share * static_cast<double>(across - 1)));
        rows[scale.row(panel.y[i], height)][std::min(column, across - 1)] = '*';
    }
    std::string out = fmt::format("{}\n", panel.label);
    for (std::size_t i = 0; i < height; ++i) {
        const double value =
            scale.high - (scale.high - scale.low) * static_cast<double>(i) / static_cast<double>(height - 1);
        const bool named = i == 0 || i + 1 == height || i == height / 2;
        out += fmt::format("{} |{}\n", named ? fmt::format("{:>8.5g}", value) : std::string(8, ' '), rows[i]);
    }
    const auto begin = fmt::format("{:g} s", x.front());
    const auto end = fmt::format("{:.3g} s", x.back());
    return out + fmt::format("{}{}{:>{}}\n", std::string(margin, ' '), begin, end, across - begin.size());
}

std::string sparkline(const std::vector<double>& values, std::size_t width)
{
    static constexpr std::array<std::string_view, 8> blocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    const std::size_t shown = std::min(width, values.size());
    const auto first = values.end() - static_cast<std::ptrdiff_t>(shown);
    if (shown == 0)
        return {};
    const auto [low, high] = std::minmax_element(first, values.end());
    const double span = *high - *low;
    std::string out;
    for (auto value = first; value != values.end(); ++value) {
        const double share = span > 0.0 ? (*value - *low) / span : 0.0;
        out += blocks[std::min<std::size_t>(static_cast<std::size_t>(share * 8.0), 7)];
    }
    return out;
}

} // namespace sinew::cli
