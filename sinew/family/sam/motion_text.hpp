#pragma once
#include "sinew/base/error.hpp"
#include "sinew/wire/message.hpp"

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The self-running program of a SAM as text, an instruction a line (L492-507; gaps and guesses: S64):
///
///     # to and fro
///     go 82                 quick coordinates 0 … 254, or an angle from the middle such as 45deg
///     go 82 level 2         with less torque: 0 is the strongest, 4 the weakest
///     wait 266ms            up to 4094 ms; what ends in a byte 255 cannot be sent
///     until position >= 90  = > < >= <=
///     until ad > 50         the external port in 8 bit
///     wheel cw 5            cw or ccw; 0 stops, 15 is the fastest
///     passive
///     brake
///     outputs 1 2           the outputs that are on; none
///     repeat 3              from the first line; forever
///     end
namespace sinew::sam {

inline constexpr std::size_t most_instructions = 8;

struct Program {
    std::vector<wire::Pair> instructions;
    std::vector<std::string> places; ///< "PATH:LINE" of each
};

/// `bad_file` with "PATH:LINE: what is wrong and what would be right". No more than eight instructions, at least one.
std::expected<Program, Error> assemble(std::string_view text, std::string_view path);

/// Where an instruction sends the shaft, from the middle; nothing: it is no `go`.
std::optional<double> goes_to_rad(wire::Pair instruction);
/// Whether it turns the shaft without end.
bool turns_on(wire::Pair instruction);

/// A line each, which `assemble` reads again as the same bytes where the document explains them; what it does not
/// explain is a comment with its bytes.
std::string disassemble(std::span<const wire::Pair> instructions);

} // namespace sinew::sam
