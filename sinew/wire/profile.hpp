#pragma once
#include "sinew/wire/row.hpp"

#include <span>
#include <string_view>

namespace sinew::wire {

/// What a model or firmware line says differently about one field. Messages and fields by name; an empty message means
/// every message with such a field.
struct Override {
    std::string_view message{};
    std::string_view field{};
    Range range{};      ///< not given: as the row says
    double scale = 0.0; ///< 0: as the row says
    double offset = 0.0;
    std::string_view source{};
};

/// A firmware line: the messages that exist on it, and what it reads differently. What is not listed is refused,
/// because the same opcode can mean a factory reset elsewhere.
struct Profile {
    std::string_view name;
    std::string_view says;
    std::string_view source;
    std::span<const MessageInfo* const> messages;
    Options options{};
    std::span<const Override> overrides{};

    constexpr const MessageInfo* find(std::string_view message) const
    {
        for (const auto* info : messages)
            if (info->name() == message)
                return info;
        return nullptr;
    }

    constexpr bool has(const MessageInfo& message) const
    {
        for (const auto* info : messages)
            if (info == &message)
                return true;
        return false;
    }
};

/// How the raw value of one field is read: `raw * scale + offset` in the unit of the field, and what may travel.
struct Reading {
    Range range;
    double scale = 1.0; ///< 0: the model says
    double offset = 0.0;

    constexpr double physical(std::int64_t raw) const { return static_cast<double>(raw) * scale + offset; }
};

/// The reading of a field after the overrides, the later ones winning: first the profile's, then the model's.
constexpr Reading reading(const MessageInfo& message, const Field& field, std::span<const Override> profile,
                          std::span<const Override> model = {})
{
    Reading out{allowed(field), field.scale, field.offset};
    for (const auto list : {profile, model})
        for (const auto& o : list) {
            if (o.field != field.name || (!o.message.empty() && o.message != message.name()))
                continue;
            if (o.range.given())
                out.range = o.range;
            if (o.scale != 0.0) {
                out.scale = o.scale;
                out.offset = o.offset;
            }
        }
    return out;
}

} // namespace sinew::wire
