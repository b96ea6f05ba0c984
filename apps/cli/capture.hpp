#pragma once
#include "sinew/base/error.hpp"
#include "sinew/wire/frame.hpp"

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// What people paste: bytes in hex or lines of candump.
namespace sinew::cli {

/// A line that was understood: a CAN frame, or a run of bytes of a serial line.
using Captured = std::variant<wire::Frame, std::vector<std::uint8_t>>;

/// `can0  141   [8]  A2 00 …`, `(1436509052.249713) can0 141#A200…`, `141#A200…` and bytes in hex as `from_hex` takes
/// them. `bad_hex` says what is wrong with the line.
std::expected<Captured, Error> parse_capture(std::string_view line);

/// The lines of a text that are worth reading: not empty, no comment (`#`, `;`, `//`).
struct Line {
    std::size_t number = 0; ///< from 1
    std::string_view text;
};
std::vector<Line> lines_of(std::string_view text);

} // namespace sinew::cli
