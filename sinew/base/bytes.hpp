#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sinew {

/// "FF E0 A0": two digits a byte, one space between.
std::string to_hex(std::span<const std::uint8_t> bytes);

/// Bytes from hex text. Digits may stand together or apart (blanks, commas, `:`, `0x`). An odd number of digits in a
/// group is an error that names it, but for one digit behind `0x`; so is anything that is no digit.
std::expected<std::vector<std::uint8_t>, Error> from_hex(std::string_view text);

/// A whole number as people write it: 12, -3, 0x1F. The whole text must be the number.
std::expected<std::int64_t, Error> to_integer(std::string_view text);

/// The candidate with the smallest edit distance to `word`, or an empty view when none is near.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// ", did you mean X?" for the nearest candidate, or nothing.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

} // namespace sinew
