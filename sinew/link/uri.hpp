#pragma once
#include "sinew/base/error.hpp"

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sinew::link {

/// The name of a bus as one string: `serial:/dev/ttyUSB0?baud=1500000`, `tcp://192.168.0.7:4001`,
/// `slcan:/dev/ttyACM0?bitrate=1000000`, `sim:arm.toml#left`. Nothing in it is escaped: a target cannot hold '?' or
/// '#'.
struct Uri {
    std::string scheme;
    std::string target;   ///< device, host:port or file
    std::string fragment; ///< what follows '#'
    std::vector<std::pair<std::string, std::string>> options;

    std::optional<std::string_view> option(std::string_view name) const;
    /// A whole positive number; absent is fine, anything else is `bad_uri` with the option's name.
    std::expected<std::optional<std::uint32_t>, Error> number(std::string_view name) const;
};

/// `bad_uri` with what is wrong and how it is written.
std::expected<Uri, Error> parse_uri(std::string_view text);

/// The link with a bit rate where it leads to a serial port and says none; any other as it was.
std::string with_bit_rate(const std::string& link, std::uint32_t bit_rate);

/// The text again, options in the order they stood in.
std::string to_string(const Uri& uri);

} // namespace sinew::link
