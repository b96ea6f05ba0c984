#pragma once
#include "sinew/base/error.hpp"
#include "sinew/record/captured.hpp"

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

/// What people paste: bytes in hex or lines of candump.
namespace sinew::cli {

using record::Captured;

/// `can0  141   [8]  A2 00 …`, `(1436509052.249713) can0 141#A200…`, `141#A200…` and bytes in hex as `from_hex` takes
/// them. `bad_hex` says what is wrong with the line. Of a CAN frame only those that a family may use are taken. Neither
/// time nor bus are kept: a log is read by `record::CandumpReader`.
std::expected<Captured, Error> parse_capture(std::string_view line);

/// The lines of a text that are worth reading: not empty, no comment (`#`, `;`, `//`).
struct Line {
    std::size_t number = 0; ///< from 1
    std::string_view text;
};
std::vector<Line> lines_of(std::string_view text);

} // namespace sinew::cli
