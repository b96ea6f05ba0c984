#pragma once
#include <span>
#include <string>
#include <vector>

namespace sinew::cli {

/// A curve in Braille dots, two by four to a character: as many lines as `height`, top first. `x` ascends.
std::vector<std::string> chart(std::span<const double> x, std::span<const double> y, std::size_t width,
                               std::size_t height);

} // namespace sinew::cli
