#pragma once
#include "apps/cli/device.hpp"

/// Short names for messages that read or set something: what is left without the word that says so.
namespace sinew::cli {

/// "read-input-voltage" → "input-voltage", "request-position-feedback" → "position"; nothing for other messages.
std::optional<std::string> reads_what(const wire::MessageInfo& message);
/// "set-pd-gain" → "pd-gain", "write-acceleration-ram" → "acceleration-ram".
std::optional<std::string> sets_what(const wire::MessageInfo& message);

/// By short or full name, `unknown_name` with the nearest short one.
std::expected<const wire::MessageInfo*, Error> reader_named(const Device& device, std::string_view name);
std::expected<const wire::MessageInfo*, Error> setter_named(const Device& device, std::string_view name);

/// Whether a read can be sent without being told anything, to this device.
bool asks_nothing(const Device& device, const wire::MessageInfo& message);

} // namespace sinew::cli
