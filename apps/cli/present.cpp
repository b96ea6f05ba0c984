#include "apps/cli/present.hpp"

#include "sinew/base/bytes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>

namespace sinew::cli {
namespace {

std::string flags(std::span<const wire::Label> labels, std::int64_t raw)
{
    std::string out;
    const auto add = [&](std::string_view word) { out += fmt::format("{}{}", out.empty() ? "" : ", ", word); };
    for (const auto& label : labels)
        if ((raw & label.value) != 0) {
            add(label.name);
            raw &= ~label.value;
        }
    if (raw != 0)
        add(fmt::format("unexplained 0x{:X}", raw));
    return out;
}

std::string label_of(const wire::Field& field, std::int64_t raw)
{
    for (const auto& label : field.labels)
        if (label.value == raw)
            return std::string(label.name);
    return !field.labels.empty() && are_flags(field.labels) ? flags(field.labels, raw) : std::string{};
}

} // namespace

bool are_flags(std::span<const wire::Label> labels)
{
    return std::ranges::all_of(
        labels, [](const auto& l) { return l.value > 0 && std::has_single_bit(static_cast<std::uint64_t>(l.value)); });
}

std::vector<Shown> show(const Device& device, const wire::MessageInfo& message, const wire::Values& values)
{
    std::vector<Shown> out;
    for (const auto& [field, raw] : values) {
        Shown shown{.name = field->name, .raw = raw, .label = label_of(*field, raw)};
        const auto reading = device.reading(message, *field);
        // Positions of a SAM get scale and centre, and so their unit, from the model alone.
        const bool model_only = field->unit.empty() && (reading.scale != 1.0 || reading.offset != 0.0);
        if (reading.scale != 0.0 && (!field->unit.empty() || model_only)) {
            shown.value = reading.physical(raw);
            shown.unit = model_only ? "deg" : field->unit;
        }
        out.push_back(std::move(shown));
    }
    return out;
}

std::string number(double value)
{
    constexpr int digits = 6;
    return fmt::format("{:.{}g}", value == 0.0 ? 0.0 : value, digits);
}

std::string text(const Shown& value)
{
    if (!value.label.empty())
        return value.label;
    if (value.value)
        return fmt::format("{} {}", number(*value.value), value.unit);
    return std::to_string(value.raw);
}

Json to_json(const std::vector<Shown>& values)
{
    Json out = Json::array();
    for (const auto& v : values) {
        Json one = Json::object({{"name", v.name}, {"raw", v.raw}});
        if (v.value) {
            // The digits that a raw number times its scale really has.
            one.set("value", std::round(*v.value * 1e9) / 1e9);
            one.set("unit", v.unit);
        }
        if (!v.label.empty())
            one.set("label", v.label);
        out.add(std::move(one));
    }
    return out;
}

Table table_of(const std::vector<Shown>& values)
{
    Table table({"FIELD", "RAW", "VALUE"});
    for (const auto& v : values)
        table.add({std::string(v.name), std::to_string(v.raw), v.value || !v.label.empty() ? text(v) : ""});
    return table;
}

std::string describe(const wire::MessageInfo& message, wire::Direction direction, int id)
{
    const bool request = direction == wire::Direction::request;
    const auto whom = id >= 0 ? fmt::format(" {} id {}", request ? "to" : "from", id) : std::string{};
    const bool own_name = request || !message.request.exists();
    return fmt::format("{}{}{}", own_name ? "" : "reply to ", message.name(), whom);
}

std::string_view to_word(wire::Access access)
{
    switch (access) {
    case wire::Access::read:
        return "read";
    case wire::Access::command:
        return "command";
    case wire::Access::flash:
        return "flash";
    }
    return "";
}

std::string to_text(const wire::Frame& frame, bool can)
{
    const auto hex = to_hex(frame.bytes());
    return can ? fmt::format("{:03X}#{}", frame.can_id, hex) : hex;
}

} // namespace sinew::cli
