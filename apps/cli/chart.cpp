#include "apps/cli/chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace sinew::cli {
namespace {

constexpr std::size_t across = 2, down = 4; // dots of a character
constexpr std::array<std::array<std::uint8_t, down>, across> dots{{{0x01, 0x02, 0x04, 0x40}, {0x08, 0x10, 0x20, 0x80}}};

/// U+2800 and the dots, in UTF-8.
std::string braille(std::uint8_t bits)
{
    return {'\xE2', static_cast<char>(0xA0 | bits >> 6), static_cast<char>(0x80 | (bits & 0x3F))};
}

std::size_t place(double value, double low, double high, std::size_t count)
{
    const double share = high > low ? (value - low) / (high - low) : 0.5;
    return static_cast<std::size_t>(std::lround(share * static_cast<double>(count - 1)));
}

} // namespace

std::vector<std::string> chart(std::span<const double> x, std::span<const double> y, std::size_t width,
                               std::size_t height)
{
    std::vector<std::vector<std::uint8_t>> cells(height, std::vector<std::uint8_t>(width));
    if (!x.empty()) {
        const auto [low, high] = std::ranges::minmax(y);
        std::size_t before = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            const std::size_t column = place(x[i], x.front(), x.back(), width * across);
            const std::size_t row = height * down - 1 - place(y[i], low, high, height * down);
            // A curve without gaps: from the row of the value before to that of this one.
            const auto [top, bottom] = std::minmax(i == 0 ? row : before, row);
            for (std::size_t r = top; r <= bottom; ++r)
                cells[r / down][column / across] |= dots[column % across][r % down];
            before = row;
        }
    }
    std::vector<std::string> out(height);
    for (std::size_t row = 0; row < height; ++row)
        for (const std::uint8_t cell : cells[row])
            out[row] += braille(cell);
    return out;
}

} // namespace sinew::cli
