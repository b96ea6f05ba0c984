#pragma once
#include "apps/cli/device.hpp"
#include "apps/cli/json.hpp"
#include "apps/cli/terminal.hpp"

/// Values for people and programs: raw, and what they mean.
namespace sinew::cli {

/// One value worked out.
struct Shown {
    std::string_view name;
    std::int64_t raw = 0;
    std::optional<double> value; ///< in `unit`; nothing where the row has no scale, or the model is not known
    std::string_view unit;
    std::string label; ///< the word for the raw value, or the flags that are set
};

std::vector<Shown> show(const Device& device, const wire::MessageInfo& message, const wire::Values& values);

/// Whether labels name single bits and not values.
bool are_flags(std::span<const wire::Label> labels);

/// "90 deg", "CW", "17"; short enough for one column.
std::string text(const Shown& value);
/// A number without digits that mean nothing.
std::string number(double value);

Json to_json(const std::vector<Shown>& values);

/// NAME, RAW, VALUE.
Table table_of(const std::vector<Shown>& values);

/// "reset-position to id 3"
std::string describe(const wire::MessageInfo& message, wire::Direction direction, int id);

/// What access means for a person: "read", "command", "flash".
std::string_view to_word(wire::Access access);

/// The frame as people write it: "FF E0 …", and with its identifier on CAN ("141#A2000000…").
std::string to_text(const wire::Frame& frame, bool can);

} // namespace sinew::cli
